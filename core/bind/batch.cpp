// Batches, as Python calls them.
#include "batch/batch.hpp"

#include "bind/fields.hpp"
#include "bind/given_scene.hpp"
#include "bind/lanes.hpp"
#include "derivatives/derivatives.hpp"
#include "scene/joint_axes.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

using Matrix = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Output = nb::ndarray<double, nb::c_contig, nb::device::cpu>;
using Codes = nb::ndarray<std::int8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

// The numbers of a batch by name: none, one row that all share, or one each.
Column column_of(const nb::dict& arrays, const char* name, std::size_t rows, std::size_t width) {
    Column column;
    if (!arrays.contains(name) || arrays[name].is_none()) return column;
    const Matrix given = array_as_it_is<Matrix>(arrays[name], name);
    column.data = given.data();
    column.width = width;
    column.varies = given.shape(0) > 1;
    if (given.shape(1) != width || (given.shape(0) != 1 && given.shape(0) != rows))
        throw nb::value_error((std::string(name) + ": must be (1 or rows, " +
                               std::to_string(width) + "), got (" + std::to_string(given.shape(0)) +
                               ", " + std::to_string(given.shape(1)) + ")")
                                  .c_str());
    return column;
}

template <typename A>
auto* output_of(const nb::dict& outputs, const char* name, std::size_t size) {
    const A array = array_as_it_is<A>(outputs[name], name);
    if (array.size() != size)
        throw nb::value_error((std::string(name) + ": expected " + std::to_string(size) +
                               " numbers, got " + std::to_string(array.size()))
                                  .c_str());
    return array.data();
}

// A scene is read by one more batch.
struct InUse {
    const GivenScene& scene;
    explicit InUse(const GivenScene& own) : scene(own) { ++scene.batches; }
    ~InUse() { --scene.batches; }
    InUse(const InUse&) = delete;
    InUse& operator=(const InUse&) = delete;
};

// The part that all batches of a scene have in common.
struct Program {
    const GivenScene& given;
    Batch batch;

    Program(const GivenScene& scene, const ContactLaw& law, bool is_regular,
            std::vector<int> joints, const Links& links)
        : given(scene) {
        if (law.contacts.size() != scene.scene.contacts.size())
            throw nb::value_error("law: must have coefficients for each contact");
        for (int joint : joints) check_body(scene.model, joint);
        batch.scene = &scene.scene;
        batch.law = &law;
        batch.is_regular = is_regular;
        batch.joints = std::move(joints);
        batch.links = links.links;
    }
};

void set_inputs(const GivenScene& self, const nb::dict& arrays, BatchInput& in) {
    const Scene& scene = self.scene;
    const std::size_t nv = self.model.nv, contacts = scene.contacts.size();
    struct Input {
        const char* name;
        std::size_t width;
        Column BatchInput::* column;
        bool is_needed;
    };
    const std::size_t blows = 6 * scene.blows.size() + scene.kicks.size(),
                      rows = scene.function_rows * nv,
                      functions = scene.function_contacts * (1 + 3 * nv);
    const Input inputs[] = {
        {"q", static_cast<std::size_t>(self.model.nq), &BatchInput::q, true},
        {"v", nv, &BatchInput::v, true},
        {"impulses", blows, &BatchInput::impulses, blows > 0},
        {"restitution", contacts, &BatchInput::restitution, false},
        {"friction", contacts, &BatchInput::friction, false},
        {"masses", scene.loads.size(), &BatchInput::masses, !scene.loads.empty()},
        {"points", 3 * scene.points.size(), &BatchInput::points, !scene.points.empty()},
        {"function_rows", rows, &BatchInput::function_rows, rows > 0},
        {"function_contacts", functions, &BatchInput::function_contacts, functions > 0}};
    for (const Input& input : inputs) {
        in.*input.column = column_of(arrays, input.name, in.size, input.width);
        if (input.is_needed && !(in.*input.column).data)
            throw nb::value_error("an array of the batch is missing");
    }
}

void set_outputs(const Program& program, const nb::dict& outputs, std::size_t B, BatchOutput& out) {
    const Scene& scene = program.given.scene;
    const std::size_t nv = program.given.model.nv, contacts = scene.contacts.size();
    struct Field {
        const char* name;
        std::size_t width;
        double* BatchOutput::* array;
    };
    const Field fields[] = {{"v_after", nv, &BatchOutput::v_after},
                            {"dv", nv, &BatchOutput::dv},
                            {"generalized_impulse", nv, &BatchOutput::generalized_impulse},
                            {"energy_change", 1, &BatchOutput::energy_change},
                            {"contact_impulses", 3 * contacts, &BatchOutput::contact_impulses},
                            {"normal_components", 3 * contacts, &BatchOutput::normal_components},
                            {"gaps", contacts, &BatchOutput::gaps},
                            {"constraint_impulses", static_cast<std::size_t>(scene.rows()),
                             &BatchOutput::constraint_impulses},
                            {"reactions", 6 * program.batch.joints.size(), &BatchOutput::reactions},
                            {"bodies", 6 * program.batch.links.size(), &BatchOutput::bodies}};
    for (const Field& field : fields)
        if (outputs.contains(field.name))
            out.*field.array = output_of<Output>(outputs, field.name, B * field.width);
    out.codes = output_of<Codes>(outputs, "codes", B);
}

// Results and parameters to differentiate, and the outputs for slopes and their existence.
void set_slopes(const GivenScene& self, const nb::dict& arrays, const nb::dict& outputs,
                Batch& batch) {
    const Scene& scene = self.scene;
    const int results = self.model.nv + scene.rows() + 3 * static_cast<int>(scene.contacts.size());
    BatchInput& in = batch.in;
    in.results = nb::cast<std::vector<int>>(arrays["results"]);
    in.parameters = nb::cast<std::vector<int>>(arrays["parameters"]);
    in.weights = column_of(arrays, "weights", in.size, results);
    const auto check = [](const std::vector<int>& numbers, int count) {
        for (int i : numbers)
            if (i < 0 || i >= count)
                throw nb::value_error("results, parameters: expected numbers below their counts");
    };
    check(in.results, results);
    check(in.parameters, Parameters(scene).count);
    const std::size_t sets = in.weights.data ? 1 : in.results.size(), B = in.size;
    batch.out.slopes = output_of<Output>(outputs, "slopes", B * sets * in.parameters.size());
    batch.out.existence = output_of<Codes>(outputs, "existence", B);
}

void solve(const Program& program, const nb::dict& arrays, const nb::dict& outputs, int threads,
           const nb::object& tell) {
    Batch batch = program.batch;
    const Codes known = array_as_it_is<Codes>(arrays["codes"], "codes");
    batch.in.size = static_cast<int>(known.size());
    batch.in.codes = known.data();
    set_inputs(program.given, arrays, batch.in);
    set_outputs(program, outputs, known.size(), batch.out);
    if (outputs.contains("slopes")) set_slopes(program.given, arrays, outputs, batch);
    const LaneFunctions& functions = lanes();
    const InUse in_use(program.given);
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
    nb::class_<Program>(module, "Program", "What all batches of a scene have in common.")
        .def(nb::init<const GivenScene&, const ContactLaw&, bool, std::vector<int>, const Links&>(),
             nb::arg("scene"), nb::arg("law"), nb::arg("is_regular"), nb::arg("joints"),
             nb::arg("links"), nb::keep_alive<1, 2>(), nb::keep_alive<1, 3>())
        .def("solve", &solve, nb::arg("arrays"), nb::arg("outputs"), nb::arg("threads"),
             nb::arg("tell").none(), "Solve many states; arrays by name, outputs are written.");
}
