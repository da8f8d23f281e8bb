// weir.Model: a model that a Python program opens and invokes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "model_binding.hpp"

#include <pybind11/stl.h>

#include <cmath>
#include <memory>

#include "arrays.hpp"
#include "exceptions.hpp"
#include "weir/model.hpp"

namespace weir::bindings {
namespace {

std::chrono::nanoseconds to_nanoseconds(double seconds) {
  if (!(seconds >= 0 && seconds < 1e9)) throw py::value_error("a time-out is 0 or more seconds");
  return std::chrono::nanoseconds(std::llround(seconds * 1e9));
}

std::vector<std::string> to_paths(const py::object& paths) {
  const auto path = py::module_::import("os").attr("fspath");
  if (!py::isinstance<py::list>(paths) && !py::isinstance<py::tuple>(paths))
    return {py::cast<std::string>(path(paths))};
  std::vector<std::string> out;
  for (const auto part : py::reinterpret_borrow<py::sequence>(paths))
    out.push_back(py::cast<std::string>(path(part)));
  return out;
}

// Each call holds a reference while it runs, so that close() may be called concurrently.
class ModelObject {
 public:
  ModelObject(const py::object& paths, const std::string& engine, const std::string& accelerator,
              int threads, const py::dict& options, double timeout, const py::dict& declared) {
    ModelOptions wanted{engine, accelerator, threads, {}, to_nanoseconds(timeout)};
    for (const auto& [key, value] : options)
      wanted.options.emplace_back(py::str(key), py::str(value));
    for (const auto& [key, value] : declared)
      wanted.declared.emplace_back(py::str(key), py::str(value));
    const auto files = to_paths(paths);
    auto opened = unlocked([&] { return Model::open(files, wanted); });
    model_ = std::make_shared<Model>(value_of_model(std::move(opened)));
  }
  ModelObject(const ModelObject&) = delete;
  ModelObject& operator=(const ModelObject&) = delete;
  ~ModelObject() { close(); }

  std::shared_ptr<Model> get() const {
    if (!model_) throw py::value_error("the model is closed");
    return model_;
  }
  bool is_closed() const noexcept { return !model_; }
  void close() {
    unlocked([model = std::move(model_)]() mutable { model.reset(); });
  }

 private:
  std::shared_ptr<Model> model_;
};

// The arrays of one frame or of all.
py::list make_arrays(const py::object& owner, const Outputs& outputs, std::optional<size_t> frame) {
  py::list arrays;
  for (size_t i = 0; i < outputs.size(); ++i)
    arrays.append(make_array(frame ? outputs.of_frame(*frame, i) : outputs[i], owner));
  return arrays;
}

py::object make_keeper(std::unique_ptr<Outputs> outputs) {
  const auto end = [](void* kept) { delete static_cast<Outputs*>(kept); };
  py::capsule keeper(outputs.get(), end);
  outputs.release();
  return keeper;
}

py::object invoke(const ModelObject& self, const py::object& inputs) {
  const LentArrays lent(inputs);
  const auto model = self.get();
  auto result = unlocked([&] { return model->invoke(lent.views()); });
  auto outputs = std::make_unique<Outputs>(value_of_model(std::move(result)));
  if (outputs->dropped()) return py::none();
  const Outputs& made = *outputs;
  return make_arrays(make_keeper(std::move(outputs)), made, std::nullopt);
}

py::object invoke_batch(const ModelObject& self, const py::sequence& frames) {
  std::vector<LentArrays> lent;
  for (const auto frame : frames) lent.emplace_back(py::reinterpret_borrow<py::object>(frame));
  std::vector<std::vector<TensorView>> views;
  for (const auto& frame : lent) views.push_back(frame.views());
  const auto model = self.get();
  auto result = unlocked([&] { return model->invoke_batch(views); });
  auto outputs = std::make_unique<Outputs>(value_of_model(std::move(result)));
  if (outputs->dropped()) return py::none();
  const Outputs& made = *outputs;
  const py::object keeper = make_keeper(std::move(outputs));
  py::list all;
  for (size_t frame = 0; frame < made.frames(); ++frame)
    all.append(make_arrays(keeper, made, frame));
  return all;
}

void reshape(const ModelObject& self, const py::sequence& shapes) {
  std::vector<TensorShape> wanted;
  for (const auto shape : shapes) wanted.push_back(shape_from(shape));
  const auto model = self.get();
  value_of_model(unlocked([&] { return model->reshape(wanted); }));
}

constexpr const char* kModel = R"(A model that the program opens with any engine and invokes.

Model(paths, engine="", accelerator="", threads=0, options={}, timeout=0.0, declared={})

    with weir.Model("net.onnx") as model:
        scores, = model(image)

paths: a file, or a list of files
engine: the name of the engine, such as "onnxruntime"; "" selects it by the extensions of the files
accelerator: the accelerator in the engine's terms; "" is the engine's default
threads: the number of threads for one call; 0 is the engine's default
options: the options of the engine, as a dict
timeout: the time limit of a call in seconds; 0 is no limit
declared: the properties input, inputtype, output... of tensor_filter, as a dict, for engines that need them

Any thread can call a model. Calls of the same model wait for each other. Other Python threads run during a call.)";

void bind_tensor_info(py::module_& module) {
  py::class_<TensorInfo>(module, "TensorInfo", "The description of one tensor of a model.")
      .def_readonly("name", &TensorInfo::name)
      .def_property_readonly(
          "dtype", [](const TensorInfo& info) { return to_dtype(info.type); },
          "the NumPy dtype, or None if it is open")
      .def_property_readonly("shape", &make_shape,
                             "the shape, outermost dimension first; None for an open dimension, or "
                             "if the rank is unknown")
      .def_readonly("scale", &TensorInfo::scale,
                    "real = scale * (value - zero_point); 0: not quantised")
      .def_readonly("zero_point", &TensorInfo::zero_point)
      .def("__repr__",
           [](const TensorInfo& info) { return "<weir.TensorInfo " + info.to_string() + ">"; })
      .def("__str__", &TensorInfo::to_string);
}

}  // namespace

void bind_model(py::module_& module) {
  bind_tensor_info(module);
  using Object = ModelObject;
  py::class_<Object>(module, "Model", kModel)
      .def(py::init<const py::object&, const std::string&, const std::string&, int, const py::dict&,
                    double, const py::dict&>(),
           py::arg("paths"), py::arg("engine") = "", py::arg("accelerator") = "",
           py::arg("threads") = 0, py::arg("options") = py::dict(), py::arg("timeout") = 0.0,
           py::arg("declared") = py::dict())
      .def_property_readonly("closed", &Object::is_closed, "True after close()")
      .def_property_readonly(
          "engine", [](const Object& self) { return self.get()->engine(); },
          "the name of the engine that runs the model")
      .def_property_readonly(
          "engine_version", [](const Object& self) { return self.get()->engine_version(); },
          "the version of the engine's library")
      .def_property_readonly(
          "metadata", [](const Object& self) { return self.get()->metadata(); },
          "the metadata of the model's file as JSON; \"\" if it has none")
      .def_property_readonly(
          "inputs", [](const Object& self) { return py::tuple(py::cast(self.get()->inputs())); },
          "one TensorInfo per tensor, with the current shapes; reshape() changes them")
      .def_property_readonly(
          "outputs", [](const Object& self) { return py::tuple(py::cast(self.get()->outputs())); },
          "one TensorInfo per tensor that the model returns")
      .def("reshape", &reshape, py::arg("shapes"),
           "Sets the open dimensions with one shape for each input; () is the model's own shape.")
      .def(
          "set_timeout",
          [](const Object& self, double seconds) {
            self.get()->set_timeout(to_nanoseconds(seconds));
          },
          py::arg("seconds"), "The time limit of later calls in seconds; 0 = none.")
      .def("invoke", &invoke, py::arg("inputs"),
           "Runs the model on an array, or on a list with one array for each input. Returns a list "
           "of read-only arrays in new memory, or None if the model drops the frame.")
      .def("invoke_batch", &invoke_batch, py::arg("frames"),
           "Runs several frames at once, each as for invoke(). Returns a list of outputs for each "
           "frame.")
      .def("close", &Object::close, "Frees the model when the running calls have returned.")
      .def("__enter__", [](py::object self) { return self; })
      .def("__exit__", [](Object& self, const py::args&) { self.close(); });
}

}  // namespace weir::bindings
