// weir.Pipeline: a pipeline that a Python program plays.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline_binding.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>

#include "arrays.hpp"
#include "raised.hpp"
#include "weir/pipeline.hpp"

namespace weir::bindings {
namespace {

using Seconds = std::optional<double>;

std::optional<Nanoseconds> nanoseconds_of(const Seconds& seconds) {
  if (!seconds) return std::nullopt;
  if (!(*seconds >= 0 && *seconds < 1e9)) throw py::value_error("a time-out is 0 or more seconds");
  return Nanoseconds(std::llround(*seconds * 1e9));
}
std::optional<Nanoseconds> time_of(const std::optional<int64_t>& nanoseconds) {
  return nanoseconds ? std::optional(Nanoseconds(*nanoseconds)) : std::nullopt;
}
std::optional<int64_t> number_of(const std::optional<Nanoseconds>& time) {
  return time ? std::optional<int64_t>(time->count()) : std::nullopt;
}

py::array tensor_of(const Frame& frame, py::ssize_t index) {
  const auto size = static_cast<py::ssize_t>(frame.size());
  if (index < 0) index += size;
  if (index < 0 || index >= size) throw py::index_error("the frame has no such tensor");
  auto kept = std::make_unique<Frame>(frame);
  const Tensor tensor = (*kept)[static_cast<size_t>(index)];
  const py::capsule owner(kept.get(), [](void* end) { delete static_cast<Frame*>(end); });
  kept.release();
  return array_of(tensor, owner);
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
  // Calls the Pipeline without the GIL and raises its error.
  template <class Body>
  auto call(Body&& body) const {
    const auto pipeline = get();
    auto result = unlocked([&] { return body(*pipeline); });
    if (!result) raise(result.error(), cause_of(result.error()));
    if constexpr (requires { *result; }) return *std::move(result);
  }
  const std::shared_ptr<RaisedInStream>& raised_in_stream() const { return raised_; }
  void forget_raised() const { *raised_ = {}; }

 private:
  // Null unless a function of the program raised the exception that is this error.
  py::object cause_of(const Error& error) const {
    const bool is_raised =
        error.code == Code::CALLBACK_FAILED && error.what.ends_with(raised_->text);
    return is_raised ? raised_->exception : py::object();
  }

  std::shared_ptr<RaisedInStream> raised_ = freed_with_gil(new RaisedInStream);
  std::shared_ptr<Pipeline> pipeline_;
};

using Object = PipelineObject;

void push(const Object& self, const std::string& name, const py::object& arrays,
          const std::optional<int64_t>& pts, const std::optional<int64_t>& duration) {
  const LentArrays lent(arrays);
  PushOptions options;
  options.pts = time_of(pts);
  options.duration = time_of(duration);
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
  return interruptible(nanoseconds_of(timeout), [&](const auto& limit) {
    return self.call([&](Pipeline& p) { return p.wait(limit); });
  });
}

std::optional<Frame> pull(const Object& self, const std::string& name, const Seconds& timeout) {
  std::optional<Frame> frame;
  interruptible(nanoseconds_of(timeout), [&](const auto& limit) {
    frame = self.call([&](Pipeline& p) { return p.pull(name, limit); });
    return frame || self.call([&](Pipeline& p) { return p.ended(name); });
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

void bind_frame(py::module_& module) {
  py::class_<Frame>(module, "Frame",
                    "A frame that came out of a pipeline: len(frame) tensors, frame[i] a read-only "
                    "array over its memory. Times in nanoseconds of running time, or None.")
      .def("__len__", &Frame::size)
      .def("__getitem__", &tensor_of)
      .def_property_readonly("pts", [](const Frame& f) { return number_of(f.pts()); })
      .def_property_readonly("duration", [](const Frame& f) { return number_of(f.duration()); })
      .def_property_readonly("caps", &Frame::caps, "GStreamer's text");
}

constexpr const char* kPipeline =
    R"(A pipeline, from the text that gst-launch-1.0 takes: appsrc name=in ! ... ! tensor_sink name=out

with weir.Pipeline(text) as pipeline starts and stops it. What an element reports on its bus is the error of every later call,
until stop(). Any thread may call. Time-outs are seconds, None = without limit; times of frames are nanoseconds.)";

}  // namespace

void bind_pipeline(py::module_& module) {
  bind_frame(module);
  py::class_<Object>(module, "Pipeline", kPipeline)
      .def(py::init<const std::string&>(), py::arg("text"))
      .def("start", [](const Object& s) { s.call([](Pipeline& p) { return p.start(); }); })
      .def("pause", [](const Object& s) { s.call([](Pipeline& p) { return p.pause(); }); })
      .def("stop",
           [](const Object& s) {
             s.call([](Pipeline& p) { return p.stop(); });
             s.forget_raised();
           })
      .def("close", &Object::close, "Stops and frees the pipeline.")
      .def_property_readonly("closed", &Object::is_closed, "True after close()")
      .def_property_readonly("state", &state, "\"stopped\", \"paused\" or \"playing\"")
      .def("wait", &wait, py::arg("timeout") = py::none(),
           "Waits until every stream has ended. Returns False on time-out. Ctrl-C interrupts it.")
      .def("push", &push, py::arg("name"), py::arg("arrays"), py::arg("pts") = py::none(),
           py::arg("duration") = py::none(),
           "Pushes a frame into the appsrc `name`: an array, or a list of arrays, one for each "
           "tensor.")
      .def(
          "end",
          [](const Object& self, const std::string& name) {
            self.call([&](Pipeline& p) { return p.end(name); });
          },
          py::arg("name"), "Ends the stream of the appsrc `name`.")
      .def("pull", &pull, py::arg("name"), py::arg("timeout") = py::none(),
           "The next Frame of the sink `name`; None on time-out or, if ended() is True "
           "then, at the end of the stream.")
      .def(
          "ended",
          [](const Object& self, const std::string& name) {
            return self.call([&](Pipeline& p) { return p.ended(name); });
          },
          py::arg("name"))
      .def("on_frame", &on_frame, py::arg("name"), py::arg("function"),
           "Called with each Frame on a thread of the stream, instead of pulling; None: pulled "
           "again. An exception ends the stream. It cannot stop, pause or start its own pipeline "
           "(weir.Error, CANCELLED) but may close it.")
      .def("set", &set, py::arg("element"), py::arg("property"), py::arg("value"))
      .def(
          "get",
          [](const Object& self, const std::string& element, const std::string& property) {
            return self.call([&](Pipeline& p) { return p.get(element, property); });
          },
          py::arg("element"), py::arg("property"), "Returns the property as text.")
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
