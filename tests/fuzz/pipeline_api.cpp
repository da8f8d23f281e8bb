// Fuzz target: calls the C API of pipelines in any order, with NULL anywhere and arbitrary names,
// properties and values. The pipelines are fixed, because arbitrary descriptions could write any
// file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "weir/pipeline.h"

#include <deque>
#include <string>
#include <vector>

#include "fuzz_input.hpp"
#include "weir/model.h"

namespace {

using weir::fuzz::FuzzInput;
using weir::fuzz::require;

constexpr const char* kTexts[] = {
    "appsrc name=in ! valve name=gate ! appsink name=out sync=false",
    "appsrc name=in "
    "caps=other/tensors,format=static,num_tensors=1,dimensions=4:1:1:1,types=uint8,framerate=30/1 "
    "! "
    "queue name=gate max-size-buffers=2 ! appsink name=out sync=false max-buffers=2 drop=true",
    "appsrc name=in ! output-selector name=gate  gate. ! fakesink  gate. ! appsink name=out "
    "sync=false async=false",
    "fakesrc num-buffers=3 sizetype=fixed sizemax=10 name=in ! identity name=gate ! appsink "
    "name=out sync=false",
    "nothing-of-this-name name=in ! ( fakesink",
    "",
};
constexpr const char* kNames[] = {"in", "gate", "out", "none", ""};
constexpr const char* kProperties[] = {"drop",         "max-buffers", "max-size-time", "caps",
                                       "active-pad",   "name",        "silent",        "leaky",
                                       "emit-signals", "sleep-time"};
constexpr const char* kValues[] = {
    "true", "0", "-1", "18446744073709551616", "src_1", "sink_0", "NULL", "video/x-raw", "1e400"};
constexpr int64_t kTimeouts[] = {0, 1000000, INT64_MIN};

void check_error(int result, weir_error* error) {
  if (error) require(result < 0 && weir_error_code(error) == -result, "an error has the code");
  (void)weir_error_message(error);
  weir_error_free(error);
}

class Calls {
 public:
  // Most sequences start with a pipeline.
  explicit Calls(FuzzInput* input) : input_(*input) {
    if (!input_.rarely()) check_error(parse(nullptr), nullptr);
  }
  ~Calls() {
    weir_pulled_free(frame_);
    weir_pipeline_free(pipeline_);
  }
  void next() {
    weir_error* error = nullptr;
    weir_error** const place = !input_.rarely() ? &error : nullptr;
    const int result = input_.flag() ? move(place) : ask(place);
    check_error(result, error);
  }

 private:
  weir_pipeline* pipeline() { return !input_.rarely() ? pipeline_ : nullptr; }
  template <size_t N>
  const char* text(const char* const (&usual)[N]) {
    const uint32_t which = input_.below(16);
    if (which == 0) return nullptr;
    if (which > 2) return usual[input_.below(N)];
    texts_.emplace_back(input_.line());
    return texts_.back().c_str();
  }

  int parse(weir_error** error) {
    weir_pipeline* parsed = nullptr;
    const int result =
        weir_pipeline_parse(!input_.rarely() ? kTexts[input_.below(std::size(kTexts))] : nullptr,
                            !input_.rarely() ? &parsed : nullptr, error);
    require((result == 0) == (parsed != nullptr), "there is a pipeline or an error");
    if (parsed) {
      weir_pipeline_free(pipeline_);
      pipeline_ = parsed;
    }
    return result;
  }
  int push(weir_error** error) {
    std::vector<std::byte> memory(input_.below(4) ? 4 : input_.byte());
    weir_tensor tensors[2];
    for (auto& tensor : tensors) {
      tensor = weir_tensor_of(memory.data(), memory.size(),
                              !input_.rarely() ? uint32_t{WEIR_UINT8} : input_.below(13));
      if (input_.below(4)) {
        tensor.info.rank = 1;
        tensor.info.shape[0] =
            input_.below(4) ? static_cast<int64_t>(memory.size()) : input_.take<int64_t>();
      } else if (input_.flag()) {
        tensor.info.rank = input_.take<uint32_t>();
      }
      if (input_.rarely()) tensor.data = nullptr;
    }
    const uint32_t count = !input_.rarely() ? 1 : input_.below(3);
    return weir_pipeline_push(pipeline(), text(kNames), !input_.rarely() ? tensors : nullptr, count,
                              input_.take<int16_t>(), input_.take<int8_t>(), error);
  }
  int pull(weir_error** error) {
    weir_pulled* frame = nullptr;
    const int result = weir_pipeline_pull(pipeline(), text(kNames), timeout(),
                                          !input_.rarely() ? &frame : nullptr, error);
    require((result == WEIR_PIPELINE_DONE) == (frame != nullptr), "there is a frame or none");
    if (frame) {
      weir_pulled_free(frame_);
      frame_ = frame;
    }
    return result;
  }
  int64_t timeout() { return kTimeouts[input_.below(2)]; }

  int move(weir_error** error) {
    switch (input_.below(8)) {
      case 0:
      case 1:
        return parse(error);
      case 2:
        return weir_pipeline_start(pipeline(), error);
      case 3:
        return weir_pipeline_pause(pipeline(), error);
      case 4:
        return weir_pipeline_stop(pipeline(), error);
      case 5:
        return push(error);
      case 6:
        return pull(error);
      default:
        return weir_pipeline_end(pipeline(), text(kNames), error);
    }
  }

  int ask(weir_error** error) {
    switch (input_.below(12)) {
      case 0:
        return weir_pipeline_wait(pipeline(), timeout(), error);
      case 1: {
        weir_error* message = nullptr;
        weir_pipeline_read_message(pipeline(), &message, nullptr);
        weir_error_free(message);
        return weir_pipeline_ended(pipeline(), text(kNames), error);
      }
      case 2:
        return weir_pipeline_set(pipeline(), text(kNames), text(kProperties), text(kValues), error);
      case 3:
        return get(error);
      case 4:
        return weir_pipeline_property_type(pipeline(), text(kNames), text(kProperties), error);
      case 5: {
        int32_t value = 0;
        return weir_pipeline_get_enum(pipeline(), text(kNames), text(kProperties),
                                      !input_.rarely() ? &value : nullptr, error);
      }
      case 6:
        return weir_pipeline_set_valve(pipeline(), text(kNames), input_.byte(), error);
      case 7:
        return weir_pipeline_select(pipeline(), text(kNames), text(kValues), error);
      case 8:
        return weir_pipeline_elements(
            pipeline(), !input_.rarely() ? +[](const char*, const char*, int, void*) {} : nullptr,
            nullptr, error);
      case 9:
        return weir_pipeline_pads(pipeline(), text(kNames),
                                  !input_.rarely() ? +[](const char*, int, void*) {} : nullptr,
                                  nullptr, error);
      case 10:
        return weir_pipeline_on_frame(
            pipeline(), text(kNames),
            input_.below(4) ? +[](const weir_pulled*, void*, weir_error**) { return 0; } : nullptr,
            nullptr, error);
      default:
        read_frame();
        return 0;
    }
  }
  int get(weir_error** error) {
    char* value = nullptr;
    const int result = weir_pipeline_get(pipeline(), text(kNames), text(kProperties),
                                         !input_.rarely() ? &value : nullptr, error);
    weir_pipeline_text_free(value);
    return result;
  }
  void read_frame() {
    const weir_pulled* const frame = !input_.rarely() ? frame_ : nullptr;
    weir_tensor tensor{};
    (void)weir_pulled_pts(frame);
    (void)weir_pulled_duration(frame);
    (void)weir_pulled_caps(frame);
    (void)weir_pulled_count(frame);
    weir_pulled_free(weir_pulled_keep(frame));
    if (weir_pulled_tensor(frame, input_.below(3), !input_.rarely() ? &tensor : nullptr) < 0)
      return;
    unsigned sum = 0;
    for (uint64_t i = 0; i < tensor.bytes; ++i) sum += static_cast<const uint8_t*>(tensor.data)[i];
    require(sum != 1u << 31, "frames can be read");
  }

  FuzzInput& input_;
  weir_pipeline* pipeline_ = nullptr;
  weir_pulled* frame_ = nullptr;
  std::deque<std::string> texts_;  // keeps their addresses
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzInput input(data, size);
  Calls calls(&input);
  while (!input.empty()) calls.next();
  return 0;
}
