// Arrays between Python and the core, checked at the border.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <string>
#include <type_traits>
#include <vector>

namespace impulsekit {

namespace nb = nanobind;

using Array = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Integers = nb::ndarray<const int, nb::c_contig, nb::device::cpu>;

// The numbers of an array that must hold `size` of them.
template <typename T>
const T* data_of(const nb::ndarray<const T, nb::c_contig, nb::device::cpu>& array, std::size_t size,
                 const char* name) {
    if (array.size() != size)
        throw nb::value_error((std::string(name) + ": expected " + std::to_string(size) +
                               " numbers, got " + std::to_string(array.size()))
                                  .c_str());
    return array.data();
}

// An array as it is: a copy in other numbers or another order would be freed at once, and what is
// written to it lost.
template <typename A>
A array_as_it_is(const nb::handle& given, const char* name) {
    A array;
    if (!nb::try_cast<A>(given, array, false))
        throw nb::type_error((std::string(name) +
                              ": must be a C-contiguous array of the type and dimensions that "
                              "the core works on")
                                 .c_str());
    return array;
}

// Run Python's handlers of signals that came, such as Ctrl-C, and throw what they raise.
inline void raise_signals() {
    const nb::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
}

// A new array of Python's that owns a copy: of doubles, of flags as truth values, of integers.
template <typename T>
auto array_of(const std::vector<T>& values) {
    using Own = std::conditional_t<std::is_same_v<T, char>, bool, T>;
    Own* copy = new Own[std::max<std::size_t>(values.size(), 1)];
    std::copy(values.begin(), values.end(), copy);
    nb::capsule owner(copy, [](void* p) noexcept { delete[] static_cast<Own*>(p); });
    return nb::ndarray<nb::numpy, Own, nb::ndim<1>>(copy, {values.size()}, owner);
}

}  // namespace impulsekit
