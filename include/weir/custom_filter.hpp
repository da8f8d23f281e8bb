// Filters of the application in C++: any callable, or a class, registered for the lifetime of an
// object. A callable:
//
//   const weir::RegisteredFilter doubler(
//       "doubler",
//       {.inputs = {weir::tensor_info("x", WEIR_FLOAT32, {4})},
//        .outputs = {weir::tensor_info("y", WEIR_FLOAT32, {4})}},
//       [](std::span<const weir_tensor> in, std::span<weir_tensor> out) {
//         const auto x = weir::elements<const float>(in[0]);
//         const auto y = weir::elements<float>(out[0]);
//         for (size_t i = 0; i < x.size(); ++i) y[i] = 2 * x[i];
//       });
//   ... tensor_filter framework=custom-easy model=doubler ...
//
// The object takes ownership of the callable. The callable may take whole frames with their times
// instead: (const weir_frame& in, weir_frame& out). If it returns bool, false drops the frame. An
// exception becomes an error on the bus; weir::Failure sets its text. Calls are serialised unless
// thread_safe is set. With dynamic, the callable allocates each output: weir::allocate(&out[0],
// weir::tensor_info(...), bytes).
//
// Destroying the object releases the name. Pipelines that use the filter continue with it, and the
// callable is destroyed with the last of them.
//
// A class, as described in engine.hpp; each element that names it opens its own object:
//
//   const weir::RegisteredFilterClass<Threshold> threshold("threshold");
//   ... tensor_filter framework=cpp model=threshold custom=limit:99 ...
//
// In a shared object that links with libweir, WEIR_FILTER_CLASS(Threshold, "threshold") registers
// the class when the file is loaded: model=threshold,/path/to/lib.so. A shared object that exports
// the class with WEIR_ENGINE (engine.hpp) is found the same way and links nothing of Weir.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "weir/custom_filter.h"
#include "weir/engine.hpp"
#include "weir/module.hpp"

namespace weir {

// Inputs, outputs and flags of a filter; custom_filter.h documents each.
struct FilterDescription {
  std::vector<weir_tensor_info> inputs, outputs;
  bool dynamic = false;
  bool thread_safe = false;
  bool stateful = false;
  // Computes the outputs for these inputs when `outputs` leaves them open.
  std::function<void(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out)>
      resolve = {};
};

// The functions of custom_filter.h and error.h. A program that does not link with libweir fills the
// members with the results of dlsym.
struct FilterFunctions {
  decltype(&weir_filter_register) add;
  decltype(&weir_filter_unregister) remove;
  decltype(&weir_filter_class_register) add_class;
  decltype(&weir_filter_class_unregister) remove_class;
  decltype(&weir_error_what) what, offered, needed, difference, fix;
  decltype(&weir_error_free) free;

  static FilterFunctions linked() noexcept {
    return {weir_filter_register,
            weir_filter_unregister,
            weir_filter_class_register,
            weir_filter_class_unregister,
            weir_error_what,
            weir_error_offered,
            weir_error_needed,
            weir_error_difference,
            weir_error_fix,
            weir_error_free};
  }
  // Converts and frees the `error` of a function that returned `code`.
  Error take(int code, weir_error* error) const {
    Error out{.code = static_cast<Code>(-code),
              .what = what(error),
              .offered = offered(error),
              .needed = needed(error),
              .difference = difference(error),
              .fix = fix(error)};
    free(error);
    return out;
  }
};

// Returns false, with a line on standard error, when `register_it` throws.
template <class Body>
bool kept(Body&& register_it) noexcept {
  try {
    register_it();
    return true;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "weir: %s\n", e.what());
    return false;
  }
}

class RegisteredFilter {
 public:
  // Throws Failure when the name is empty, reserved or taken, or the description is invalid.
  template <class Function>
  RegisteredFilter(std::string name, FilterDescription description, Function function,
                   const FilterFunctions& functions = FilterFunctions::linked())
      : name_(std::move(name)), remove_(functions.remove) {
    using Held = Holder<Function>;
    auto held = std::make_unique<Held>(Held{std::move(function), std::move(description.resolve)});
    weir_filter filter{};
    filter.struct_size = sizeof filter;
    if (description.dynamic) filter.flags |= WEIR_FILTER_DYNAMIC;
    if (description.thread_safe) filter.flags |= WEIR_FILTER_THREAD_SAFE;
    if (description.stateful) filter.flags |= WEIR_FILTER_STATEFUL;
    filter.n_inputs = static_cast<uint32_t>(description.inputs.size());
    filter.n_outputs = static_cast<uint32_t>(description.outputs.size());
    filter.inputs = description.inputs.data();
    filter.outputs = description.outputs.data();
    filter.invoke = Held::invoke;
    if (held->resolver) filter.resolve = Held::resolve;
    filter.data = held.get();
    filter.release = [](void* data) { delete static_cast<Held*>(data); };
    weir_error* error = nullptr;
    const int result = functions.add(name_.c_str(), &filter, &error);
    if (result < 0) throw Failure(functions.take(result, error));
    held.release();
  }
  // Registers from a library that is being loaded, where nothing may be thrown: the name stays
  // taken until the process ends. Returns false, with a line on standard error, on failure.
  template <class Function>
  static bool keep(std::string name, FilterDescription description, Function function) noexcept {
    return kept([&] {
      RegisteredFilter filter(std::move(name), std::move(description), std::move(function));
      filter.name_.clear();
    });
  }
  RegisteredFilter(const RegisteredFilter&) = delete;
  RegisteredFilter& operator=(const RegisteredFilter&) = delete;
  RegisteredFilter(RegisteredFilter&& other) noexcept
      : name_(std::exchange(other.name_, {})), remove_(other.remove_) {}
  ~RegisteredFilter() {
    if (!name_.empty()) remove_(name_.c_str());
  }

 private:
  template <class Function>
  struct Holder {
    Function function;
    decltype(FilterDescription::resolve) resolver;

    // An exception of user code is a failed callback, not a fault of Weir.
    template <class Body>
    static int guarded_call(const weir_host* host, weir_error* error, Body&& body) noexcept {
      static const bool accepted = accept_host(host);  // for allocate()
      (void)accepted;
      const auto failed = [&](int code, const char* text) {
        return host->fail(error, code, text, nullptr, nullptr, nullptr, nullptr);
      };
      try {
        return body();
      } catch (const Failure& failure) {
        return fail(*host, error, failure.error());
      } catch (const std::bad_alloc&) {
        return failed(WEIR_OUT_OF_MEMORY, "memory ran out in a filter");
      } catch (const std::exception& e) {
        return failed(WEIR_CALLBACK_FAILED, e.what());
      } catch (...) {
        return failed(WEIR_CALLBACK_FAILED, "an unknown exception");
      }
    }
    template <class In, class Out>
    static int call(Function& function, const In& in, Out& out) {
      if constexpr (std::is_void_v<std::invoke_result_t<Function&, const In&, Out&>>) {
        function(in, out);
        return WEIR_OK;
      } else {
        return function(in, out) ? WEIR_OK : 1;
      }
    }
    static int invoke(const weir_host* host, const weir_frame* in, weir_frame* out, void* data,
                      weir_error* error) {
      return guarded_call(host, error, [&] {
        auto& own = static_cast<Holder*>(data)->function;
        if constexpr (std::is_invocable_v<Function&, const weir_frame&, weir_frame&>) {
          return call(own, *in, *out);
        } else {
          const std::span<const weir_tensor> inputs(in->tensors, in->n_tensors);
          std::span<weir_tensor> outputs(out->tensors, out->n_tensors);
          return call(own, inputs, outputs);
        }
      });
    }
    static int resolve(const weir_host* host, const weir_tensor_info* in, uint32_t n_in,
                       weir_tensor_info* out, uint32_t n_out, void* data, weir_error* error) {
      return guarded_call(host, error, [&] {
        static_cast<Holder*>(data)->resolver({in, n_in}, {out, n_out});
        return WEIR_OK;
      });
    }
  };

  std::string name_;
  decltype(&weir_filter_unregister) remove_;
};

// Registers the class `Filter` under a name for the lifetime of the object. Its code must stay
// loaded until the last element that opened it has stopped.
template <class Filter>
class RegisteredFilterClass {
 public:
  // Throws Failure when the name is empty or taken.
  explicit RegisteredFilterClass(std::string name,
                                 const FilterFunctions& functions = FilterFunctions::linked())
      : name_(std::move(name)), remove_(functions.remove_class) {
    weir_error* error = nullptr;
    const int result = functions.add_class(name_.c_str(), entry, &error);
    if (result < 0) throw Failure(functions.take(result, error));
  }
  // Registers as RegisteredFilter::keep does.
  static bool keep(const char* name) noexcept {
    return kept([&] {
      RegisteredFilterClass filter{std::string(name)};
      filter.name_.clear();
    });
  }
  RegisteredFilterClass(const RegisteredFilterClass&) = delete;
  RegisteredFilterClass& operator=(const RegisteredFilterClass&) = delete;
  ~RegisteredFilterClass() {
    if (!name_.empty()) remove_(name_.c_str());
  }

 private:
  static const weir_module* entry(const weir_host* host) {
    static const bool accepted = accept_host(host);
    static const weir_engine table = engine_table<Filter>("cpp", "1", "", "");
    static const weir_engine* const tables[] = {&table, nullptr};
    static const weir_module module{sizeof(weir_module),
                                    WEIR_ABI_MAJOR,
                                    WEIR_ABI_MINOR,
                                    tables,
                                    nullptr,
                                    nullptr,
                                    nullptr,
                                    nullptr};
    return accepted ? &module : nullptr;
  }

  std::string name_;
  decltype(&weir_filter_class_unregister) remove_;
};

}  // namespace weir

// In a shared object that links with libweir: registers the class when the file is loaded. Prints a
// line on standard error when the name is taken.
#define WEIR_FILTER_CLASS(Filter, name)                           \
  [[maybe_unused]] static const bool weir_filter_class_##Filter = \
      ::weir::RegisteredFilterClass<Filter>::keep(name);
