// Numbers that geometry is written in: a double, eight of them side by side, or one with its
// derivatives; and vectors and rotations of such numbers.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

namespace impulsekit {

// Eight states side by side.
inline constexpr int kLanes = 8;
using Pack = double __attribute__((vector_size(8 * kLanes)));
using PackBits = std::int64_t __attribute__((vector_size(8 * kLanes)));

// Traits of a number: its bits and the entries of its states.
template <typename S>
struct Number;

template <>
struct Number<double> {
    using Bits = std::int64_t;
    static constexpr int lanes = 1;
    static double get(const double& x, int) { return x; }
    static void set(double& x, int, double value) { x = value; }
    static std::int64_t bit(Bits x, int) { return x; }
};

template <>
struct Number<Pack> {
    using Bits = PackBits;
    static constexpr int lanes = kLanes;
    static double get(const Pack& x, int lane) { return x[lane]; }
    static void set(Pack& x, int lane, double value) { x[lane] = value; }
    static std::int64_t bit(const Bits& x, int lane) { return x[lane]; }
};

template <typename S>
S number(double value) {
    return S{} + value;
}

// A number with derivatives along N directions, N a power of two.
template <int N>
struct Dual {
    typedef double Slopes __attribute__((vector_size(8 * N)));
    double value = 0.0;
    Slopes slope{};

    friend Dual operator+(Dual a, const Dual& b) {
        a.value += b.value;
        a.slope += b.slope;
        return a;
    }
    friend Dual operator-(Dual a, const Dual& b) {
        a.value -= b.value;
        a.slope -= b.slope;
        return a;
    }
    friend Dual operator*(const Dual& a, const Dual& b) {
        return along(a.value * b.value, b.value, a, a.value, b);
    }
    friend Dual operator/(const Dual& a, const Dual& b) {
        const double ratio = a.value / b.value;
        return along(ratio, 1.0 / b.value, a, -ratio / b.value, b);
    }
    friend Dual operator+(Dual a, double b) { return a.value += b, a; }
    friend Dual operator-(Dual a, double b) { return a.value -= b, a; }
    friend Dual operator*(const Dual& a, double b) { return along(a.value * b, b, a); }
    friend Dual operator/(const Dual& a, double b) { return along(a.value / b, 1.0 / b, a); }
    friend Dual operator+(double a, const Dual& b) { return b + a; }
    friend Dual operator-(double a, const Dual& b) { return along(a - b.value, -1.0, b); }
    friend Dual operator*(double a, const Dual& b) { return b * a; }
    friend Dual operator-(const Dual& a) { return along(-a.value, -1.0, a); }
    friend Dual operator/(double a, const Dual& b) {
        return along(a / b.value, -a / (b.value * b.value), b);
    }
    // Compared by the value alone.
    friend bool operator<(const Dual& a, const Dual& b) { return a.value < b.value; }
    friend bool operator<(const Dual& a, double b) { return a.value < b; }
    friend bool operator<(double a, const Dual& b) { return a < b.value; }
    friend bool operator>(const Dual& a, const Dual& b) { return a.value > b.value; }
    friend bool operator>(const Dual& a, double b) { return a.value > b; }
    friend bool operator>(double a, const Dual& b) { return a > b.value; }
    friend bool operator<=(const Dual& a, const Dual& b) { return a.value <= b.value; }
    friend bool operator<=(const Dual& a, double b) { return a.value <= b; }
    friend bool operator<=(double a, const Dual& b) { return a <= b.value; }
    friend bool operator>=(const Dual& a, const Dual& b) { return a.value >= b.value; }
    friend bool operator>=(const Dual& a, double b) { return a.value >= b; }
    friend bool operator>=(double a, const Dual& b) { return a >= b.value; }
    Dual& operator+=(const Dual& b) {
        value += b.value;
        slope += b.slope;
        return *this;
    }
    Dual& operator-=(const Dual& b) {
        value -= b.value;
        slope -= b.slope;
        return *this;
    }

    // A value with slope x ẋ, or x ẋ + y ẏ.
    static Dual along(double value, double x, const Dual& a) { return {value, x * a.slope}; }
    static Dual along(double value, double x, const Dual& a, double y, const Dual& b) {
        return {value, x * a.slope + y * b.slope};
    }
};

template <int N>
struct Number<Dual<N>> {
    static constexpr int lanes = 1;
    static double get(const Dual<N>& x, int) { return x.value; }
    static void set(Dual<N>& x, int, double value) { x.value = value; }
};

inline double root(double x) { return std::sqrt(x); }
inline Pack root(const Pack& x) {
    Pack y = x;
    for (int k = 0; k < kLanes; ++k) y[k] = std::sqrt(x[k]);
    return y;
}
template <int N>
Dual<N> root(const Dual<N>& x) {
    const double y = std::sqrt(x.value);
    return Dual<N>::along(y, 0.5 / y, x);
}

// |x|, and the larger and smaller of two; a NaN is neither.
inline double magnitude(double x) { return std::abs(x); }
inline Pack magnitude(const Pack& x) { return x < 0.0 ? -x : x; }
template <typename S>
S larger(const S& a, const S& b) {
    return a < b ? b : a;
}

template <typename S>
S smaller(const S& a, const S& b) {
    return b < a ? b : a;
}

inline bool any(bool x) { return x; }
inline bool any(const PackBits& x) {
    std::int64_t all = 0;
    for (int k = 0; k < kLanes; ++k) all |= x[k];
    return all != 0;
}

// Angles above this are reduced by libm: the parts of π/2 below carry no more digits.
inline constexpr double kLargestAngle = 1e5;

// sin x and cos x, by polynomials of minimax kind after x = k π/2 + r, |r| <= π/4 (fdlibm's
// kernels). The same operations for one number and for eight, so that both give the same bits.
template <typename S>
void sine_cosine(const S& x, S& sine, S& cosine) {
    using Bits = typename Number<S>::Bits;
    // Adding 1.5 2⁵² rounds to an integer, whose last bits are then those of the sum.
    const double magic = 6755399441055744.0;
    const S shifted = x * 0.63661977236758134308 + magic;
    const S k = shifted - magic;
    const S r = ((x - k * 1.57079632673412561417) - k * 6.07710050630396597660e-11) -
                k * 2.02226624879595063154e-21;
    const S z = r * r;
    const S s = r + r * z *
                        (((((z * 1.58969099521155010221e-10 - 2.50507602534068634195e-8) * z +
                            2.75573137070700676789e-6) *
                               z -
                           1.98412698298579493134e-4) *
                              z +
                          8.33333333332248946124e-3) *
                             z -
                         1.66666666666666324348e-1);
    const S half = 0.5 * z, near = 1.0 - half;
    const S c = near + (((1.0 - near) - half) +
                        z * z *
                            (((((2.08757232129817482790e-9 - z * 1.13596475577881948265e-11) * z -
                                2.75573143513906633035e-7) *
                                   z +
                               2.48015872894767294178e-5) *
                                  z -
                              1.38888888888741095749e-3) *
                                 z +
                             4.16666666666666019037e-2));
    Bits quarter;
    std::memcpy(&quarter, &shifted, sizeof quarter);
    const auto swapped = (quarter & 1) != 0;
    const auto below = (quarter & 2) != 0, left = ((quarter + 1) & 2) != 0;
    const S first = swapped ? c : s, second = swapped ? s : c;
    sine = below ? -first : first;
    cosine = left ? -second : second;
    if (!any(x * x > kLargestAngle * kLargestAngle)) return;
    for (int lane = 0; lane < Number<S>::lanes; ++lane) {
        const double angle = Number<S>::get(x, lane);
        if (std::abs(angle) <= kLargestAngle) continue;
        Number<S>::set(sine, lane, std::sin(angle));
        Number<S>::set(cosine, lane, std::cos(angle));
    }
}

template <int N>
void sine_cosine(const Dual<N>& x, Dual<N>& sine, Dual<N>& cosine) {
    double s, c;
    sine_cosine(x.value, s, c);
    sine = Dual<N>::along(s, c, x);
    cosine = Dual<N>::along(c, -s, x);
}

template <typename S>
struct Vec3 {
    S x{}, y{}, z{};

    Vec3 operator+(const Vec3& b) const { return {x + b.x, y + b.y, z + b.z}; }
    Vec3 operator-(const Vec3& b) const { return {x - b.x, y - b.y, z - b.z}; }
    Vec3 operator-() const { return {-x, -y, -z}; }
    template <typename T>
    Vec3 operator*(const T& a) const {
        return {x * a, y * a, z * a};
    }
    Vec3& operator+=(const Vec3& b) { return *this = *this + b; }
    Vec3& operator-=(const Vec3& b) { return *this = *this - b; }
};

template <typename S>
S dot(const Vec3<S>& a, const Vec3<S>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <typename S>
Vec3<S> cross(const Vec3<S>& a, const Vec3<S>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// One of three: of a vector or of the columns of a matrix.
template <typename T>
auto& entry(T& a, int i) {
    return i == 0 ? a.x : i == 1 ? a.y : a.z;
}

template <typename S>
Vec3<S> vec3(const double* a) {
    return {number<S>(a[0]), number<S>(a[1]), number<S>(a[2])};
}

// A vector of one of the states, and one set there.
template <typename S>
Vec3<double> lane_of(const Vec3<S>& a, int lane) {
    return {Number<S>::get(a.x, lane), Number<S>::get(a.y, lane), Number<S>::get(a.z, lane)};
}
template <typename S>
void set_lane(Vec3<S>& to, int lane, const Vec3<double>& a) {
    Number<S>::set(to.x, lane, a.x);
    Number<S>::set(to.y, lane, a.y);
    Number<S>::set(to.z, lane, a.z);
}

// A rotation, or any matrix, by columns: the axes that it turns x, y, z into.
template <typename S>
struct Mat3 {
    Vec3<S> x, y, z;

    Vec3<S> operator*(const Vec3<S>& a) const { return x * a.x + y * a.y + z * a.z; }
    Mat3 operator*(const Mat3& b) const { return {*this * b.x, *this * b.y, *this * b.z}; }
};

template <typename S>
Mat3<double> lane_of(const Mat3<S>& r, int lane) {
    return {lane_of(r.x, lane), lane_of(r.y, lane), lane_of(r.z, lane)};
}

template <typename S>
Mat3<S> transposed(const Mat3<S>& r) {
    return {{r.x.x, r.y.x, r.z.x}, {r.x.y, r.y.y, r.z.y}, {r.x.z, r.y.z, r.z.z}};
}

// Rᵀ a.
template <typename S>
Vec3<S> back(const Mat3<S>& r, const Vec3<S>& a) {
    return {dot(r.x, a), dot(r.y, a), dot(r.z, a)};
}

// Entries row by row, and a matrix given so.
inline void to_rows(const Mat3<double>& r, double* to) {
    const double rows[9] = {r.x.x, r.y.x, r.z.x, r.x.y, r.y.y, r.z.y, r.x.z, r.y.z, r.z.z};
    std::memcpy(to, rows, sizeof rows);
}
template <typename S>
Mat3<S> mat3(const double* a) {
    return {{number<S>(a[0]), number<S>(a[3]), number<S>(a[6])},
            {number<S>(a[1]), number<S>(a[4]), number<S>(a[7])},
            {number<S>(a[2]), number<S>(a[5]), number<S>(a[8])}};
}

template <typename S>
Mat3<S> identity() {
    const S one = number<S>(1.0), zero{};
    return {{one, zero, zero}, {zero, one, zero}, {zero, zero, one}};
}

// A symmetric matrix.
template <typename S>
struct Sym3 {
    S xx{}, xy{}, xz{}, yy{}, yz{}, zz{};

    Vec3<S> operator*(const Vec3<S>& a) const {
        return {xx * a.x + xy * a.y + xz * a.z, xy * a.x + yy * a.y + yz * a.z,
                xz * a.x + yz * a.y + zz * a.z};
    }
    Sym3 operator+(const Sym3& b) const {
        return {xx + b.xx, xy + b.xy, xz + b.xz, yy + b.yy, yz + b.yz, zz + b.zz};
    }
};

// R A Rᵀ.
template <typename S>
Sym3<S> turned(const Mat3<S>& r, const Sym3<S>& a) {
    const Mat3<S> k{r.x * a.xx + r.y * a.xy + r.z * a.xz, r.x * a.xy + r.y * a.yy + r.z * a.yz,
                    r.x * a.xz + r.y * a.yz + r.z * a.zz};
    return {k.x.x * r.x.x + k.y.x * r.y.x + k.z.x * r.z.x,
            k.x.x * r.x.y + k.y.x * r.y.y + k.z.x * r.z.y,
            k.x.x * r.x.z + k.y.x * r.y.z + k.z.x * r.z.z,
            k.x.y * r.x.y + k.y.y * r.y.y + k.z.y * r.z.y,
            k.x.y * r.x.z + k.y.y * r.y.z + k.z.y * r.z.z,
            k.x.z * r.x.z + k.y.z * r.y.z + k.z.z * r.z.z};
}

// The same of six entries xx, xy, xz, yy, yz, zz.
inline void turn_entries(const Mat3<double>& r, const double* from, double* to) {
    const Sym3<double> i =
        turned(r, Sym3<double>{from[0], from[1], from[2], from[3], from[4], from[5]});
    const double entries[6] = {i.xx, i.xy, i.xz, i.yy, i.yz, i.zz};
    std::memcpy(to, entries, sizeof entries);
}

// The rotation of a unit quaternion x, y, z, w.
template <typename S>
Mat3<S> of_quaternion(const S& i, const S& j, const S& k, const S& u) {
    return {{1.0 - 2.0 * (j * j + k * k), 2.0 * (i * j + u * k), 2.0 * (i * k - u * j)},
            {2.0 * (i * j - u * k), 1.0 - 2.0 * (i * i + k * k), 2.0 * (j * k + u * i)},
            {2.0 * (i * k + u * j), 2.0 * (j * k - u * i), 1.0 - 2.0 * (i * i + j * j)}};
}

}  // namespace impulsekit
