// python3 decoder: the class CustomDecoder of a Python script turns tensors into any stream
// (docs/compatibility/decoder.md 5.9).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>
#include <optional>

#include "frame_hold.hpp"
#include "numpy_api.hpp"
#include "scripts.hpp"
#include "weir/decoder.hpp"

namespace {

using weir::python::Locked;
using weir::python::Object;
using weir::python::PyObject;

constexpr char kDecoding[] = R"py(
import gc
from weir_scripts import DTYPES, TensorShape, is_a

def collect():
    gc.collect()

def caps(script):
    if not hasattr(script, "getOutCaps"):
        return b"application/octet-stream"
    made = script.getOutCaps()
    if is_a(str, made):
        return made.encode()
    if not is_a(bytes, made):
        raise TypeError(f"getOutCaps returns caps as bytes, b'text/x-raw,format=utf8', not {type(made).__name__}")
    return made

def decode(script, arrays, infos, rate_n, rate_d):
    shapes = [TensorShape(dims, DTYPES[kind]) for kind, *dims in infos]
    made = script.decode(arrays, shapes, rate_n, rate_d)
    if is_a(str, made):
        raise TypeError("decode returns bytes, not str: text.encode()")
    try:
        memoryview(made)
    except TypeError:
        raise TypeError(f"decode returns bytes, not {type(made).__name__}") from None
    return made
)py";

class Script {
 public:
  explicit Script(const weir::Options& options)
      : api_(*weir::value_or_throw(weir::python::interpreter())) {
    const auto path = options.get("option1");
    if (!path || path->empty())
      throw weir::Failure({.code = weir::Code::OPTION_VALUE,
                           .what = "mode=python3 has no script",
                           .needed = "a file of Python",
                           .fix = "tensor_decoder mode=python3 option1=/path/to/script.py"});
    path_ = *path;
    const Locked lock;
    weir::value_or_throw(weir::python::script_names());
    numpy_ = weir::value_or_throw(weir::python::Numpy::open(api_));
    names_ = weir::value_or_throw(weir::python::module_of_ours("weir_decoding", kDecoding));
    script_ = weir::value_or_throw(weir::python::load_script(path_, "CustomDecoder", {}));
  }
  Script(const Script&) = delete;
  Script& operator=(const Script&) = delete;
  ~Script() {
    const Locked lock;
    const Object ended = std::move(script_);
  }

  void set_stream(const weir::DecoderStream& stream) noexcept { stream_ = stream; }

  void configure(std::span<const weir_tensor_info>, weir::DecoderOutput& output) {
    std::string text;
    {
      const Locked lock;
      const Object caps = call("caps", Object::share(script_.get()));
      char* begin = nullptr;
      ptrdiff_t size = 0;
      if (api_.PyBytes_AsStringAndSize(caps.get(), &begin, &size) < 0) throw_exception();
      text.assign(begin, static_cast<size_t>(size));
    }
    output.set_caps(text);
  }

  bool decode(const weir_frame& frame, weir::DecoderOutput& output) {
    if (kept_) throw weir::Failure(*kept_);
    const Locked lock;
    weir::python::FrameHold hold(api_);
    if (!hold.owner()) throw_exception();
    const auto failed = run(frame, hold.owner(), output);
    if (!hold.let_go()) {
      call("collect");  // a reference cycle may hold the array
      if (!hold.is_gone()) {
        kept_ = kept_its_input();  // the array points to freed memory: never run the script again
        throw weir::Failure(*kept_);
      }
    }
    if (failed) throw weir::Failure(*failed);
    return true;
  }

 private:
  [[noreturn]] static void throw_exception() {
    throw weir::Failure(weir::python::take_exception(weir::Code::OUT_OF_MEMORY));
  }
  weir::Error kept_its_input() const {
    return {.code = weir::Code::INVOKE_FAILED,
            .what = "the script keeps an array of its input, whose memory is gone after decode",
            .offered = path_,
            .needed = "a copy",
            .difference = {},
            .fix = "array.copy()"};
  }

  // Typed arrays over the frame's memory, all with `owner`.
  Object arrays_of(const weir_frame& frame, const Object& owner) const {
    Object arrays = Object::adopt(api_.PyList_New(frame.n_tensors));
    for (uint32_t i = 0; arrays && i < frame.n_tensors; ++i) {
      const auto& tensor = frame.tensors[i];
      const auto count = tensor.bytes / weir::element_bytes(tensor.info.type);
      Object array = numpy_.view(tensor.info.type, tensor.data, static_cast<int64_t>(count), owner);
      if (!array) throw_exception();
      api_.PyList_SetItem(arrays.get(), i, array.release());
    }
    if (!arrays) throw_exception();
    return arrays;
  }

  // A list [type, dimensions innermost first...] for each tensor.
  Object infos_of(const weir_frame& frame) const {
    Object infos = Object::adopt(api_.PyList_New(frame.n_tensors));
    for (uint32_t i = 0; infos && i < frame.n_tensors; ++i) {
      const auto& info = frame.tensors[i].info;
      Object one = Object::adopt(api_.PyList_New(1 + info.rank));
      if (!one) throw_exception();
      api_.PyList_SetItem(one.get(), 0, number(info.type).release());
      for (uint32_t d = 0; d < info.rank; ++d)
        api_.PyList_SetItem(one.get(), 1 + d, number(weir::dimension(info, d)).release());
      api_.PyList_SetItem(infos.get(), i, one.release());
    }
    if (!infos) throw_exception();
    return infos;
  }
  Object number(int64_t value) const {
    Object out = Object::adopt(api_.PyLong_FromLongLong(value));
    if (!out) throw_exception();
    return out;
  }

  std::optional<weir::Error> run(const weir_frame& frame, const Object& owner,
                                 weir::DecoderOutput& output) {
    try {
      const Object made = call("decode", Object::share(script_.get()), arrays_of(frame, owner),
                               infos_of(frame), number(stream_.rate_n), number(stream_.rate_d));
      write(made.get(), output);
      return std::nullopt;
    } catch (const weir::Failure& failure) {
      weir::Error error = failure.error();
      if (error.offered.empty())
        error.offered = path_;  // the error has no traceback into the script
      return error;
    }
  }

  template <class... Arguments>
  Object call(const char* function, Arguments... arguments) {
    std::vector<Object> all;
    (all.push_back(std::move(arguments)), ...);
    return weir::value_or_throw(
        weir::python::call(names_, function, std::move(all), weir::Code::INVOKE_FAILED));
  }

  void write(PyObject* made, weir::DecoderOutput& output) const {
    const weir::python::HeldBuffer from(made, weir::python::kSimpleBuffer);
    if (!from) throw weir::Failure(weir::python::take_exception(weir::Code::INVOKE_FAILED));
    if (from->size == 0) return;
    const auto to = output.reserve(static_cast<size_t>(from->size));
    std::memcpy(to.data(), from->bytes, to.size());
  }

  const weir::python::PythonApi& api_;
  weir::python::Numpy numpy_;
  PyObject* names_ = nullptr;  // the kDecoding module; exists until the process exits
  Object script_;
  weir::DecoderStream stream_;
  std::string path_;                 // of the script
  std::optional<weir::Error> kept_;  // set once the script keeps an array of its input
};

}  // namespace

WEIR_DECODER(Script, "python3", "python",
             R"([{"name":"option1","type":"file","default":"",)"
             R"("help":"a Python file with a class CustomDecoder"}])")
