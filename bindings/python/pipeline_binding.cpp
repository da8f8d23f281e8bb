// weir.Pipeline: a pipeline that a Python program plays.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline_binding.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <type_traits>

#include "arrays.hpp"
#include "exceptions.hpp"
#include "weir/pipeline.hpp"

namespace weir::bindings {
namespace {

using Seconds = std::optional<double>;

std::optional<Nanoseconds> to_nanoseconds(const Seconds& seconds) {
  if (!seconds) return std::nullopt;
  if (!(*seconds >= 0 && *seconds < 1e9)) throw py::value_error("a time-out is 0 or more seconds");
  return Nanoseconds(std::llround(*seconds * 1e9));
}
std::optional<Nanoseconds> to_time(const std::optional<int64_t>& nanoseconds) {
  return nanoseconds ? std::optional(Nanoseconds(*nanoseconds)) : std::nullopt;
}
// The first exception that the program's functions raised since the pipeline started. Guarded by
// the GIL.
struct RaisedInStream {
  py::object exception;
  std::string text;
};

template <class T>
std::shared_ptr<T> freed_with_gil(T* object) {
  return {object, [](T* freed) {
            const py::gil_scoped_acquire locked;
            delete freed;
          }};
}

// A Python function that streaming threads call. An exception in it ends the stream.
std::function<void(const Frame&)> on_stream(py::function function,
                                            std::shared_ptr<RaisedInStream> first) {
  const auto kept = freed_with_gil(new py::function(std::move(function)));
  return [kept, first = std::move(first)](const Frame& frame) {
    const py::gil_scoped_acquire locked;
    try {
      (*kept)(frame);
    } catch (const py::error_already_set& raised) {
      const std::string text = raised.what();  // here, because what() needs the GIL
      if (!first->exception) {
        *first = {raised.value(), text};
        // A function written in C has none.
        if (raised.trace()) PyException_SetTraceback(raised.value().ptr(), raised.trace().ptr());
      }
      throw std::runtime_error(text);
    }
  };
}

// Each call holds a reference while it runs, so that close() may be called concurrently.
class PipelineObject {
 public:
  explicit PipelineObject(const std::string& text) {
    auto made = unlocked([&] { return Pipeline::parse(text); });
    pipeline_ = std::make_shared<Pipeline>(value_or_raise(std::move(made)));
  }
  PipelineObject(const PipelineObject&) = delete;
  PipelineObject& operator=(const PipelineObject&) = delete;
  ~PipelineObject() { close(); }

  std::shared_ptr<Pipeline> get() const {
    if (!pipeline_) throw py::value_error("the pipeline is closed");
    return pipeline_;
  }
  bool is_closed() const noexcept { return !pipeline_; }
  void close() {
    unlocked([pipeline = std::move(pipeline_)]() mutable { pipeline.reset(); });
  }
  static void issue_warnings(Pipeline& pipeline) {
    while (const auto message = pipeline.read_message())
      if (!message->is_error) warn(message->error);
  }
  // Calls the Pipeline without the GIL and raises its error.
  template <class Body>
  auto call_without_warnings(Body&& body) const {
    const auto pipeline = get();
    auto result = unlocked([&] { return body(*pipeline); });
    if (!result) raise(result.error(), get_cause(result.error()));
    if constexpr (requires { *result; }) return *std::move(result);
  }
  // Does the same, and issues the warnings of elements, which the program's filter may raise: an
  // error goes first, and a result that cannot be had again needs call_without_warnings().
  template <class Body>
  auto call(Body&& body) const {
    const auto pipeline = get();
    if constexpr (std::is_same_v<decltype(body(*pipeline)), Status>) {
      call_without_warnings(body);
      issue_warnings(*pipeline);
    } else {
      auto result = call_without_warnings(body);
      issue_warnings(*pipeline);
      return result;
    }
  }
  void stop() const {
    const auto pipeline = get();
    keep_stats(*pipeline);
    call_without_warnings([](Pipeline& p) { return p.stop(); });
    *raised_ = {};
    issue_warnings(*pipeline);
  }
  const std::shared_ptr<RaisedInStream>& raised_in_stream() const { return raised_; }
  // The stats of an element, as JSON: while the pipeline is stopped, those at its last stop,
  // because a stopped element has no counters of its model.
  std::string get_stats(const std::string& element) const {
    const auto kept = stats_.find(element);
    if (kept != stats_.end() && get()->state() == PipelineState::Stopped) return kept->second;
    return call([&](Pipeline& p) { return p.get_json(element, kStats); });
  }

 private:
  static constexpr const char* kStats = "stats";
  void keep_stats(Pipeline& pipeline) const {
    auto found = unlocked([&] {
      std::map<std::string, std::string> all;
      if (pipeline.state() == PipelineState::Stopped) return all;
      const auto elements = pipeline.elements();
      if (!elements) return all;
      for (const auto& [name, kind] : *elements)
        if (auto stats = pipeline.get_json(name, kStats)) all[name] = *std::move(stats);
      return all;
    });
    if (!found.empty()) stats_ = std::move(found);
  }
  // Null unless a function of the program raised the exception that is this error.
  py::object get_cause(const Error& error) const {
    const bool is_raised =
        error.code == Code::CALLBACK_FAILED && error.what.ends_with(raised_->text);
    return is_raised ? raised_->exception : py::object();
  }

  std::shared_ptr<RaisedInStream> raised_ = freed_with_gil(new RaisedInStream);
  std::shared_ptr<Pipeline> pipeline_;
  mutable std::map<std::string, std::string> stats_;  // as JSON, by element; guarded by the GIL
};

using Object = PipelineObject;

void push(const Object& self, const std::string& name, const py::object& arrays,
          const std::optional<int64_t>& pts, const std::optional<int64_t>& duration) {
  const LentArrays lent(arrays);
  PushOptions options;
  options.pts = to_time(pts);
  options.duration = to_time(duration);
  self.call([&](Pipeline& p) { return p.push(name, std::span(lent.views()), options); });
}

bool is_main_thread() {
  const auto threading = py::module_::import("threading");
  return threading.attr("get_ident")().equal(threading.attr("main_thread")().attr("ident"));
}

// Calls `step` with parts of the time limit until it returns true or the limit has passed. Python
// runs signal handlers, Ctrl-C's among them, between the parts; only the main thread runs any.
template <class Step>
bool interruptible(const std::optional<Nanoseconds>& limit, Step&& step) {
  if (!is_main_thread()) return step(limit);
  constexpr Nanoseconds kPart = std::chrono::milliseconds(50);
  const auto start = std::chrono::steady_clock::now();
  while (true) {
    const Nanoseconds left = limit ? *limit - (std::chrono::steady_clock::now() - start) : kPart;
    if (step(std::optional(std::clamp(left, Nanoseconds(0), kPart)))) return true;
    if (limit && left <= kPart) return false;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
}

bool wait(const Object& self, const Seconds& timeout) {
  return interruptible(to_nanoseconds(timeout), [&](const auto& limit) {
    return self.call([&](Pipeline& p) { return p.wait(limit); });
  });
}

std::optional<Frame> pull(const Object& self, const std::string& name, const Seconds& timeout) {
  std::optional<Frame> frame;
  interruptible(to_nanoseconds(timeout), [&](const auto& limit) {
    const auto is_ended = [&](Pipeline& p) { return p.ended(name); };
    // A warning that is raised after the pull would lose the frame. An error goes first.
    const auto pipeline = self.get();
    if (unlocked([&] { return is_ended(*pipeline); })) Object::issue_warnings(*pipeline);
    frame = self.call_without_warnings([&](Pipeline& p) { return p.pull(name, limit); });
    return frame || self.call_without_warnings(is_ended);
  });
  return frame;
}

void on_frame(const Object& self, const std::string& name, const std::optional<py::function>& f) {
  auto function = f ? on_stream(*f, self.raised_in_stream()) : std::function<void(const Frame&)>();
  self.call([&](Pipeline& p) { return p.on_frame(name, std::move(function)); });
}

void set(const Object& self, const std::string& element, const std::string& property,
         const py::object& value) {
  const bool is_bool = py::isinstance<py::bool_>(value);
  const std::string text =
      is_bool ? (py::cast<bool>(value) ? "true" : "false") : std::string(py::str(value));
  self.call([&](Pipeline& p) { return p.set(element, property, text); });
}

const char* state(const Object& self) {
  switch (self.get()->state()) {
    case PipelineState::Playing:
      return "playing";
    case PipelineState::Paused:
      return "paused";
    default:
      return "stopped";
  }
}

// The elements of the text, by name: their factories.
py::dict elements(const Object& self) {
  using Found = std::vector<std::pair<std::string, std::string>>;
  const Found found = self.call([](Pipeline& p) { return p.elements(); });
  py::dict out;
  for (const auto& [name, kind] : found) out[py::str(name)] = py::str(kind);
  return out;
}

constexpr const char* kPipeline =
    R"(A pipeline, from a text in the syntax of gst-launch-1.0.

    with weir.Pipeline("appsrc name=in ! tensor_filter model=net.onnx ! tensor_sink name=out") as pipeline:
        pipeline.push("in", image)
        pipeline.end("in")
        for frame in pipeline.frames("out"):
            print(frame[0])

`with` starts the pipeline and stops it at the end. An error that an element posts raises weir.Error in every later call, until
stop(). A warning that an element posts becomes a weir.PipelineWarning in the same call or in the next one. Any thread can call
these functions. Timeouts are in seconds; None waits without limit. Times of frames are in nanoseconds.)";

}  // namespace

void bind_pipeline(py::module_& module) {
  py::class_<Object>(module, "Pipeline", kPipeline)
      .def(py::init<const std::string&>(), py::arg("text"))
      .def(
          "start", [](const Object& s) { s.call([](Pipeline& p) { return p.start(); }); },
          "Starts the pipeline, or resumes it after pause(). Does not wait for the first frame.")
      .def(
          "pause", [](const Object& s) { s.call([](Pipeline& p) { return p.pause(); }); },
          "Pauses the pipeline; start() resumes it.")
      .def("stop", &Object::stop,
           "Stops the pipeline. Discards its frames, frames that were not pulled, and its error.")
      .def("close", &Object::close, "Stops and frees the pipeline.")
      .def_property_readonly("closed", &Object::is_closed, "True after close()")
      .def_property_readonly("state", &state, "\"stopped\", \"paused\" or \"playing\"")
      .def("wait", &wait, py::arg("timeout") = py::none(),
           "Waits until every stream has ended. Returns False on timeout. Ctrl-C interrupts it.")
      .def("push", &push, py::arg("name"), py::arg("arrays"), py::arg("pts") = py::none(),
           py::arg("duration") = py::none(),
           "Pushes a frame into the appsrc `name`: an array, or a list with one array for each "
           "tensor.")
      .def(
          "end",
          [](const Object& self, const std::string& name) {
            self.call([&](Pipeline& p) { return p.end(name); });
          },
          py::arg("name"), "Ends the stream of the appsrc `name`.")
      .def("pull", &pull, py::arg("name"), py::arg("timeout") = py::none(),
           "Returns the next Frame of the tensor_sink or appsink `name`. Returns None on timeout, "
           "and at the end of the stream, when ended() is True. Ctrl-C interrupts it.")
      .def(
          "ended",
          [](const Object& self, const std::string& name) {
            return self.call([&](Pipeline& p) { return p.ended(name); });
          },
          py::arg("name"), "True if the stream of the sink `name` has ended and no frame is left.")
      .def("on_frame", &on_frame, py::arg("name"), py::arg("function"),
           "Calls `function` with each Frame of the sink `name`, on a thread of the stream, "
           "instead of keeping frames for pull(). None keeps the frames for pull() again. Call "
           "this only while the pipeline is stopped. An exception in the function ends the stream "
           "and is the __cause__ of the weir.Error. The function can close its pipeline, but "
           "cannot start, pause or stop it.")
      .def("set", &set, py::arg("element"), py::arg("property"), py::arg("value"),
           "Sets a property of the element `element`: a bool, a number, or text as in "
           "gst-launch-1.0.")
      .def(
          "get",
          [](const Object& self, const std::string& element, const std::string& property) {
            return self.call([&](Pipeline& p) { return p.get(element, property); });
          },
          py::arg("element"), py::arg("property"), "Returns the property as text.")
      .def(
          "_get_stats",
          [](const Object& self, const std::string& element) { return self.get_stats(element); },
          py::arg("element"))
      .def("elements", &elements,
           "Returns a dict of the elements in the pipeline text: the element type, such as "
           "\"tensor_filter\", by element name.")
      .def(
          "open_valve",
          [](const Object& self, const std::string& name, bool open) {
            self.call([&](Pipeline& p) {
              auto valve = p.valve(name);
              return open ? valve.open() : valve.close();
            });
          },
          py::arg("name"), py::arg("open") = true, "Opens the valve `name`; open=False closes it.")
      .def(
          "select",
          [](const Object& self, const std::string& name, const std::string& pad) {
            self.call([&](Pipeline& p) { return p.selector(name).select(pad); });
          },
          py::arg("name"), py::arg("pad"), "Switches the input- or output-selector `name`.");
}

}  // namespace weir::bindings
