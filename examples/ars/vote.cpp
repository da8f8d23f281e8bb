// Averages results: rows of probabilities of five activities in, of one tensor or of several, their
// mean out. Its largest is what most results, weighted by how sure they are, agree on.
//
//   tensor_aggregator frames-out=6 frames-flush=1 frames-dim=1 !
//       tensor_filter framework=custom model=libars-vote.so
//   tensor_mux name=mux ! tensor_filter framework=custom model=libars-vote.so custom=inputs:2
//
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <charconv>

#include "weights.hpp"

namespace {

size_t number_of_inputs(std::string_view text) {
  size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < 1 || number > 16)
    throw weir::Failure({.code = weir::Code::OPTION_VALUE,
                         .what = "the vote's number of inputs is not usable",
                         .offered = std::string(text),
                         .needed = "a number from 1 to 16",
                         .fix = "custom=inputs:2"});
  return number;
}

class Vote {
 public:
  static constexpr uint64_t kFlags = WEIR_ENGINE_NEEDS_NO_MODEL;
  static constexpr const char* kOptions =
      R"([{"name": "inputs", "type": "integer", "default": "1", "help": "tensors of a frame"}])";

  explicit Vote(const weir::OpenRequest& request)
      : rows_(number_of_inputs(request.options.get("inputs").value_or("1")), any_rows()) {}
  std::span<const weir_tensor_info> inputs() const { return rows_; }
  std::span<const weir_tensor_info> outputs() const { return {&mean_, 1}; }
  void resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info>) const {
    for (const auto& rows : in)
      if (rows.rank < 1 || rows.rank > WEIR_RANK_LIMIT ||
          rows.shape[rows.rank - 1] != int64_t{ars::kActivities})
        throw weir::Failure({.code = weir::Code::SPEC_MISMATCH,
                             .what = "the vote's input is not rows of results",
                             .offered = weir::describe(rows),
                             .needed = "float32, innermost dimension 5: one for each activity",
                             .fix = "link it after a network of examples/ars"});
  }
  bool invoke(std::span<const weir_tensor> in, std::span<weir_tensor> out) {
    const auto mean = weir::elements<float>(out[0]);
    std::fill(mean.begin(), mean.end(), 0.0F);
    size_t count = 0;
    for (const auto& tensor : in)
      for (const float value : weir::elements<const float>(tensor))
        mean[count++ % ars::kActivities] += value;
    for (float& value : mean) value /= static_cast<float>(count / ars::kActivities);
    return true;
  }

 private:
  static weir_tensor_info any_rows() {
    weir_tensor_info info = weir::tensor_info("results", WEIR_FLOAT32, {});
    info.rank = WEIR_RANK_UNKNOWN;
    return info;
  }
  std::vector<weir_tensor_info> rows_;
  weir_tensor_info mean_ = weir::tensor_info("mean", WEIR_FLOAT32, {1, ars::kActivities});
};

}  // namespace

WEIR_ENGINE(Vote, "ars-vote", "1", "", "")
