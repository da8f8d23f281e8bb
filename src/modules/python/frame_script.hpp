// FrameScript: an instance of a class of a user's script that gets arrays over the memory of
// frames, for decoders and converters.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "frame_hold.hpp"
#include "numpy_api.hpp"
#include "weir/module.hpp"

namespace weir::python {

// Functions throw weir::Failure. One thread at a time.
class FrameScript {
 public:
  struct Kind {
    const char* class_name;   // of the script
    const char* method;       // of the class, for errors
    const char* module_name;  // of our Python module with the functions for call()
    const char* functions;    // its source; defines collect(), which runs the garbage collector
  };
  FrameScript(const Kind& kind, std::string path);
  FrameScript(const FrameScript&) = delete;
  FrameScript& operator=(const FrameScript&) = delete;
  ~FrameScript();

  // Runs `work` with the owner of the arrays over a frame's memory, under the lock of Python. Fails
  // if the script keeps an array, now and whenever it is called again.
  template <class Work>
  void with_frame(Work&& work) {
    if (kept_) throw Failure(*kept_);
    const Locked lock;
    FrameHold hold(api_);
    if (!hold.owner()) throw_exception(Code::OUT_OF_MEMORY);
    std::optional<Error> failed;
    try {
      work(hold.owner());
    } catch (const Failure& failure) {
      failed = failure.error();
      if (failed->offered.empty()) failed->offered = path_;  // no traceback into the script
    }
    release(&hold);
    if (failed) throw Failure(*failed);
  }
  // Under Locked: a function of our module, and the instance as its argument.
  template <class... Arguments>
  Object call(const char* function, Arguments... arguments) const {
    std::vector<Object> all;
    (all.push_back(std::move(arguments)), ...);
    return value_or_throw(python::call(names_, function, std::move(all), Code::INVOKE_FAILED));
  }
  Object instance() const { return Object::share(script_.get()); }
  // Under Locked: a list of arrays over the tensors, as elements or as bytes. `owner`:
  // with_frame().
  Object make_arrays(const weir_frame& frame, const Object& owner) const;
  Object make_byte_arrays(const weir_frame& frame, const Object& owner) const;

  const PythonApi& api() const noexcept { return api_; }
  // Throws Python's pending exception.
  [[noreturn]] static void throw_exception(Code code);

 private:
  template <class ArrayOf>
  Object make_list(const weir_frame& frame, ArrayOf&& make_array) const;
  void release(FrameHold* hold);

  const PythonApi& api_;
  const char* const method_;
  const std::string path_;
  Numpy numpy_;
  PyObject* names_ = nullptr;  // our module; exists until the process exits
  Object script_;
  std::optional<Error> kept_;  // set once the script keeps an array of its input
};

}  // namespace weir::python
