// Batches, as Python calls them.
#include "batch/batch.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>

#include <optional>

#include "bind/arrays.hpp"
#include "bind/given_scene.hpp"
#include "bind/lanes.hpp"
#include "derivatives/derivatives.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

using Matrix = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Output = nb::ndarray<double, nb::c_contig, nb::device::cpu>;
using Codes = nb::ndarray<std::int8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

Column column_of(const std::optional<Matrix>& given, int size, std::size_t width,
                 const char* name) {
    Column column;
    if (!given) return column;
    const std::size_t rows = given->shape(0);
    if (given->shape(1) != width || (rows != 1 && rows != static_cast<std::size_t>(size)))
        throw nb::value_error((std::string(name) + ": must be (1 or rows, " +
                               std::to_string(width) + "), got (" + std::to_string(rows) + ", " +
                               std::to_string(given->shape(1)) + ")")
                                  .c_str());
    column.data = given->data();
    column.width = width;
    column.varies = rows > 1;
    return column;
}

// Arrays of a batch by name.
struct Given {
    const nb::dict& arrays;
    int size;

    Column column(const char* name, std::size_t width) const {
        const nb::object given = arrays[name];
        std::optional<Matrix> matrix;
        if (!given.is_none()) matrix = array_as_it_is<Matrix>(given, name);
        return column_of(matrix, size, width, name);
    }
};

double* output_of(const nb::dict& outputs, const char* name, std::size_t size) {
    if (!outputs.contains(name)) return nullptr;
    const Output array = array_as_it_is<Output>(outputs[name], name);
    if (array.size() != size)
        throw nb::value_error((std::string(name) + ": expected " + std::to_string(size) +
                               " numbers, got " + std::to_string(array.size()))
                                  .c_str());
    return array.data();
}

// Results and parameters to differentiate, and the outputs for slopes and their existence.
void set_slopes(const GivenScene& self, const Given& given, const nb::dict& outputs, Batch& batch) {
    const Scene& scene = self.scene;
    const int results = self.model.nv + scene.rows() + 3 * static_cast<int>(scene.contacts.size());
    BatchInput& in = batch.in;
    in.results = nb::cast<std::vector<int>>(given.arrays["results"]);
    in.parameters = nb::cast<std::vector<int>>(given.arrays["parameters"]);
    in.weights = given.column("weights", results);
    const auto check = [](const std::vector<int>& numbers, int count) {
        for (int i : numbers)
            if (i < 0 || i >= count)
                throw nb::value_error("results, parameters: expected numbers below their counts");
    };
    check(in.results, results);
    check(in.parameters, Parameters(scene).count);
    const std::size_t sets = in.weights.data ? 1 : in.results.size(), B = in.size;
    batch.out.slopes = output_of(outputs, "slopes", B * sets * in.parameters.size());
    const Codes existence = array_as_it_is<Codes>(outputs["existence"], "existence");
    if (existence.size() != B) throw nb::value_error("existence: must have one entry for each row");
    batch.out.existence = existence.data();
}

// A scene is read by one more batch.
struct InUse {
    const GivenScene& scene;
    explicit InUse(const GivenScene& own) : scene(own) { ++scene.batches; }
    ~InUse() { --scene.batches; }
    InUse(const InUse&) = delete;
    InUse& operator=(const InUse&) = delete;
};

void solve(const GivenScene& self, const ContactLaw& law, bool is_regular,
           const std::vector<int>& joints, const std::vector<std::pair<int, Array>>& links,
           const nb::dict& arrays, const Codes& known, const nb::dict& outputs, const Codes& codes,
           int threads, const nb::object& tell) {
    const Scene& scene = self.scene;
    const std::size_t nv = self.model.nv, contacts = scene.contacts.size(), B = codes.size();
    if (law.contacts.size() != contacts || known.size() != B)
        throw nb::value_error("the law or the codes are of another size");
    Batch batch;
    batch.scene = &scene;
    batch.law = &law;
    batch.is_regular = is_regular;
    batch.joints = joints;
    for (int joint : joints) check_body(self.model, joint);
    for (const auto& [body, centre] : links) {
        check_body(self.model, body);
        Link link;
        link.body = body;
        to_body(self.model, body, data_of(centre, 3, "centre"), link.centre);
        batch.links.push_back(link);
    }
    Given given{arrays, static_cast<int>(B)};
    BatchInput& in = batch.in;
    in.size = given.size;
    in.q = given.column("q", self.model.nq);
    in.v = given.column("v", nv);
    in.impulses = given.column("impulses", 6 * scene.blows.size() + scene.kicks.size());
    in.restitution = given.column("restitution", contacts);
    in.friction = given.column("friction", contacts);
    in.masses = given.column("masses", scene.loads.size());
    in.points = given.column("points", 3 * scene.points.size());
    in.function_rows = given.column("function_rows", scene.function_rows * nv);
    in.function_contacts =
        given.column("function_contacts", scene.function_contacts * (1 + 3 * nv));
    in.codes = known.data();
    if (!in.q.data || !in.v.data || (!scene.loads.empty() && !in.masses.data) ||
        (!scene.points.empty() && !in.points.data) ||
        (scene.function_rows > 0 && !in.function_rows.data) ||
        (scene.function_contacts > 0 && !in.function_contacts.data) ||
        (scene.blows.size() + scene.kicks.size() > 0 && !in.impulses.data))
        throw nb::value_error("an array of the batch is missing");
    BatchOutput& out = batch.out;
    out.codes = codes.data();
    out.v_after = output_of(outputs, "v_after", B * nv);
    out.dv = output_of(outputs, "dv", B * nv);
    out.generalized_impulse = output_of(outputs, "generalized_impulse", B * nv);
    out.energy_change = output_of(outputs, "energy_change", B);
    out.contact_impulses = output_of(outputs, "contact_impulses", B * contacts * 3);
    out.normal_components = output_of(outputs, "normal_components", B * contacts * 3);
    out.gaps = output_of(outputs, "gaps", B * contacts);
    out.constraint_impulses = output_of(outputs, "constraint_impulses", B * scene.rows());
    out.reactions = output_of(outputs, "reactions", B * joints.size() * 6);
    out.bodies = output_of(outputs, "bodies", B * links.size() * 6);
    if (outputs.contains("slopes")) set_slopes(self, given, outputs, batch);
    const LaneFunctions& functions = lanes();
    const InUse in_use(self);
    const nb::gil_scoped_release release;
    functions.solve_rows(batch, threads, [&](int done) {
        raise_signals();
        const nb::gil_scoped_acquire hold;
        if (!tell.is_none()) tell(done);
    });
}

}  // namespace
}  // namespace impulsekit

void bind_batch(nb::module_& module) {
    using namespace impulsekit;
    module.def("solve_batch", &solve, nb::arg("scene"), nb::arg("law"), nb::arg("is_regular"),
               nb::arg("joints"), nb::arg("links"), nb::arg("arrays"), nb::arg("known"),
               nb::arg("outputs"), nb::arg("codes").noconvert(), nb::arg("threads"),
               nb::arg("tell").none(),
               "Solve many states of a scene; arrays by name, outputs are written.");
}
