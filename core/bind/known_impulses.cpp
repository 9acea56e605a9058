// Known impulses on a tree without rows, as Python calls them.
#include "impact/known_impulses.hpp"

#include "bind/given_scene.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

class BoundImpulses {
  public:
    explicit BoundImpulses(const GivenScene& given)
        : model_(given.model),
          size_(6 * given.scene.blows.size() + given.scene.kicks.size()),
          known_(checked(given)) {
        known_.leave_out_others();
    }

    nb::ndarray<nb::numpy, double, nb::ndim<1>> velocity_jump(const Array& q,
                                                              const Array& numbers) {
        std::vector<double> dv(model_.nv, 0.0);
        solve_known(known_, data_of(q, model_.nq, "q"), data_of(numbers, size_, "numbers"),
                    dv.data());
        return array_of(dv);
    }

  private:
    static const Scene& checked(const GivenScene& given) {
        if (given.model.has_followers || given.model.has_ellipsoids)
            throw nb::value_error(
                "joints that follow others, and ellipsoids, need the mass matrix");
        return given.scene;
    }

    const Model& model_;
    std::size_t size_;
    KnownImpulses<double> known_;
};

}  // namespace
}  // namespace impulsekit

void bind_known_impulses(nb::module_& module) {
    using namespace impulsekit;
    nb::class_<BoundImpulses>(module, "KnownImpulses", "The known impulses of a scene on a tree.")
        .def(nb::init<const GivenScene&>(), nb::arg("scene"), nb::keep_alive<1, 2>())
        .def("velocity_jump", &BoundImpulses::velocity_jump, nb::arg("q"), nb::arg("numbers"),
             "Return (nv,) Δv of the branches that are reached; 0 elsewhere.");
}
