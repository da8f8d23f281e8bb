// Fuzz target: calls the C API of models in any order, with NULL anywhere and arbitrary sizes. Lent
// memory has the declared size, which a program must guarantee.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "weir/model.h"

#include <array>
#include <string>
#include <vector>

#include "adding_filter.hpp"

namespace {

using weir::fuzz::FuzzInput;
using weir::fuzz::require;

constexpr int64_t kTimeouts[] = {0, -1, INT64_MIN, INT64_MAX, 1000000000};

void check_error(int result, weir_error* error) {
  if (error) require(result < 0 && weir_error_code(error) == -result, "an error has the code");
  (void)weir_error_message(error);
  weir_error_free(error);
}

class Calls {
 public:
  // Most sequences start with an open model.
  explicit Calls(FuzzInput* input) : input_(*input) {
    if (input_.rarely()) return;
    const char* const path = "adding";
    weir_model_options options = WEIR_MODEL_OPTIONS_INIT;
    options.engine = "custom-easy";
    options.paths = &path;
    options.n_paths = 1;
    require(weir_model_open(&options, &model_, nullptr) == 0, "the filter can be opened");
  }
  ~Calls() {
    weir_results_free(results_);
    weir_model_close(model_);
  }
  void next() {
    weir_error* error = nullptr;
    weir_error** const place = !input_.rarely() ? &error : nullptr;
    int result = 0;
    switch (input_.below(12)) {
      case 0:
        result = open(place);
        break;
      case 1:
        weir_model_close(model_);
        model_ = nullptr;
        break;
      case 2:
        describe();
        break;
      case 3:
        result = reshape(place);
        break;
      case 4:
        weir_model_set_timeout(model(), kTimeouts[input_.below(std::size(kTimeouts))]);
        break;
      case 5:
      case 6:
      case 7:
      case 8:
        result = invoke(place);
        break;
      case 9:
        result = invoke_into(place);
        break;
      case 10:
        read_results();
        break;
      default:
        weir_results_free(results_);
        results_ = nullptr;
    }
    check_error(result, error);
  }

 private:
  weir_loaded_model* model() { return !input_.rarely() ? model_ : nullptr; }
  std::string text(const char* usual) {
    return !input_.rarely() ? usual : std::string(input_.line());
  }

  int open(weir_error** error) {
    const std::string engine = text("custom-easy"), path = text("adding"), key = text("input"),
                      value = text("100");
    const char* const paths[] = {path.c_str(), input_.flag() ? nullptr : path.c_str()};
    const weir_option option{!input_.rarely() ? key.c_str() : nullptr,
                             !input_.rarely() ? value.c_str() : nullptr};
    weir_model_options options = WEIR_MODEL_OPTIONS_INIT;
    if (input_.rarely()) options.struct_size = input_.byte();
    options.paths = !input_.rarely() ? paths : nullptr;
    options.n_paths = !input_.rarely() ? 1 : input_.below(3);
    options.engine = !input_.rarely() ? engine.c_str() : nullptr;
    options.threads = input_.take<int8_t>();
    options.timeout_ns = kTimeouts[input_.below(std::size(kTimeouts))];
    options.options = options.declared = !input_.rarely() ? &option : nullptr;
    options.n_options = !input_.rarely() ? 0 : 1;
    options.n_declared = !input_.rarely() ? 0 : 1;
    weir_loaded_model* opened = nullptr;
    const int result = weir_model_open(!input_.rarely() ? &options : nullptr,
                                       !input_.rarely() ? &opened : nullptr, error);
    require((result == 0) == (opened != nullptr), "a model is opened or there is an error");
    if (opened) {
      weir_model_close(model_);
      model_ = opened;
    }
    return result;
  }

  void describe() {
    (void)weir_model_engine(model());
    (void)weir_model_engine_version(model());
    (void)weir_model_metadata(model());
    weir_tensor_info info;
    weir_tensor_info* const to = !input_.rarely() ? &info : nullptr;
    (void)weir_model_input(model(), input_.take<uint32_t>(), to);
    (void)weir_model_output(model(), input_.below(2), to);
    require(weir_model_input_count(model()) <= WEIR_TENSOR_LIMIT, "a model has few inputs");
    require(weir_model_output_count(model()) <= WEIR_TENSOR_LIMIT, "a model has few outputs");
  }

  weir_tensor_info info_from() {
    weir_tensor_info info = weir_tensor_of(nullptr, 0, input_.below(12)).info;
    if (input_.below(4)) return info;
    info.rank = input_.flag() ? input_.take<uint32_t>() : input_.below(4);
    for (int64_t& extent : info.shape)
      extent = input_.flag() ? input_.take<int64_t>() : input_.take<int8_t>();
    return info;
  }
  int reshape(weir_error** error) {
    const weir_tensor_info infos[] = {info_from(), info_from()};
    return weir_model_reshape(model(), !input_.rarely() ? infos : nullptr, input_.below(3), error);
  }

  // Tensors in memory of exactly their size.
  std::vector<weir_tensor> tensors_from(uint32_t count, uint32_t type, size_t usual) {
    std::vector<weir_tensor> out;
    for (uint32_t i = 0; i < count; ++i) {
      const size_t bytes = input_.below(4) ? usual : input_.byte();
      auto& memory = memories_.emplace_back(bytes, std::byte{1});
      auto tensor =
          weir_tensor_of(memory.data(), bytes, !input_.rarely() ? type : input_.below(12));
      if (input_.rarely()) tensor.info = info_from();
      if (input_.rarely()) tensor.capacity = input_.byte() % (bytes + 1);
      if (input_.rarely()) tensor.data = nullptr;
      out.push_back(tensor);
    }
    return out;
  }
  uint32_t count_from() { return !input_.rarely() ? 1 : input_.below(4); }

  int invoke(weir_error** error) {
    const bool batch = !input_.below(4);
    const uint32_t frames = !batch            ? 1
                            : input_.below(4) ? input_.below(5)
                                              : input_.take<uint32_t>();
    const uint32_t count = count_from(), max = std::min<uint32_t>(frames, 8);
    const auto inputs = tensors_from(count * max, WEIR_UINT8, 100);
    const weir_tensor* const given = !input_.rarely() ? inputs.data() : nullptr;
    weir_results* results = nullptr;
    weir_results** const place = !input_.rarely() ? &results : nullptr;
    // A callee cannot detect more frames than tensors, so the inputs are NULL in this case.
    const int result = batch ? weir_model_invoke_batch(model(), frames > max ? nullptr : given,
                                                       count, frames, place, error)
                             : weir_model_invoke(model(), given, count, place, error);
    require(result != 0 || results, "a frame has results");
    if (results) {
      weir_results_free(results_);
      results_ = results;
    }
    memories_.clear();
    return result;
  }
  int invoke_into(weir_error** error) {
    const uint32_t n_in = count_from(), n_out = count_from();
    const auto inputs = tensors_from(n_in, WEIR_UINT8, 100);
    auto outputs = tensors_from(n_out, WEIR_UINT64, 16);
    const int result =
        weir_model_invoke_into(model(), !input_.rarely() ? inputs.data() : nullptr, n_in,
                               !input_.rarely() ? outputs.data() : nullptr, n_out, error);
    memories_.clear();
    return result;
  }

  void read_results() {
    const weir_results* const results = !input_.rarely() ? results_ : nullptr;
    weir_tensor tensor{};
    weir_tensor* const to = !input_.rarely() ? &tensor : nullptr;
    const uint32_t frame = input_.below(4), index = input_.below(4) ? 0 : input_.take<uint32_t>();
    const int result = input_.flag() ? weir_results_tensor(results, index, to)
                                     : weir_results_frame_tensor(results, frame, index, to);
    if (result < 0) return;
    require(to && index < weir_results_count(results), "an output is described");
    unsigned sum = 0;
    for (uint64_t i = 0; i < tensor.bytes; ++i) sum += static_cast<const uint8_t*>(tensor.data)[i];
    require(sum != 1u << 31, "outputs can be read");
  }

  FuzzInput& input_;
  weir_loaded_model* model_ = nullptr;
  weir_results* results_ = nullptr;
  std::vector<std::vector<std::byte>> memories_;
};

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  weir::fuzz::register_adding_filter();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzInput input(data, size);
  Calls calls(&input);
  while (!input.empty()) calls.next();
  return 0;
}
