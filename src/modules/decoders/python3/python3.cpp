// python3 decoder: the class CustomDecoder of a Python script turns tensors into any stream
// (docs/compatibility/decoder.md 5.9).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "frame_script.hpp"
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

std::string get_path(const weir::Options& options) {
  const auto path = options.get("option1");
  if (!path || path->empty())
    throw weir::Failure({.code = weir::Code::OPTION_VALUE,
                         .what = "mode=python3 has no script",
                         .needed = "a Python file",
                         .fix = "tensor_decoder mode=python3 option1=/path/to/script.py"});
  return std::string(*path);
}

class Script {
 public:
  explicit Script(const weir::Options& options)
      : script_({"CustomDecoder", "decode", "weir_decoding", kDecoding}, get_path(options)) {}

  void set_stream(const weir::DecoderStream& stream) noexcept { stream_ = stream; }

  void configure(std::span<const weir_tensor_info>, weir::DecoderOutput& output) {
    std::string text;
    {
      const Locked lock;
      const Object caps = script_.call("caps", script_.instance());
      char* begin = nullptr;
      ptrdiff_t size = 0;
      if (api_.PyBytes_AsStringAndSize(caps.get(), &begin, &size) < 0) throw_exception();
      text.assign(begin, static_cast<size_t>(size));
    }
    output.set_caps(text);
  }

  bool decode(const weir_frame& frame, weir::DecoderOutput& output) {
    script_.with_frame([&](const Object& owner) {
      const Object made =
          script_.call("decode", script_.instance(), script_.make_arrays(frame, owner),
                       make_infos(frame), number(stream_.rate_n), number(stream_.rate_d));
      write(made.get(), output);
    });
    return true;
  }

 private:
  [[noreturn]] static void throw_exception() {
    weir::python::FrameScript::throw_exception(weir::Code::OUT_OF_MEMORY);
  }

  // A list [type, dimensions innermost first...] for each tensor.
  Object make_infos(const weir_frame& frame) const {
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

  void write(PyObject* made, weir::DecoderOutput& output) const {
    const weir::python::HeldBuffer from(made, weir::python::kSimpleBuffer);
    if (!from) weir::python::FrameScript::throw_exception(weir::Code::INVOKE_FAILED);
    if (from->size == 0) return;
    const auto to = output.reserve(static_cast<size_t>(from->size));
    std::memcpy(to.data(), from->bytes, to.size());
  }

  weir::python::FrameScript script_;
  const weir::python::PythonApi& api_ = script_.api();
  weir::DecoderStream stream_;
};

}  // namespace

WEIR_DECODER(Script, "python3", "python",
             R"([{"name":"option1","type":"file","default":"",)"
             R"("help":"a Python file with a class CustomDecoder"}])")
