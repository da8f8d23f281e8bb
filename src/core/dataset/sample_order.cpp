// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/dataset/sample_order.hpp"

#include <numeric>
#include <string>
#include <utility>

namespace weir::dataset {
namespace {

std::string text_of(const OrderRequest& request) {
  return "start-sample-index=" + std::to_string(request.start) +
         " stop-sample-index=" + std::to_string(request.stop);
}

}  // namespace

Result<SampleOrder> SampleOrder::make(const OrderRequest& request, uint64_t samples) {
  const uint64_t stop = request.stop == 0 && samples > 0 ? samples - 1 : request.stop;
  if (request.start >= samples || stop >= samples || request.start > stop) {
    Error error{.code = Code::OPTION_VALUE,
                .what = "the range of samples does not exist",
                .offered = text_of(request),
                .needed = samples == 0 ? "a sample: there is none"
                                       : "indices from 0 to " + std::to_string(samples - 1) +
                                             ", the first not above the last"};
    if (samples > 0) error.fix = text_of({.start = 0, .stop = samples - 1});
    return error;
  }
  const uint64_t count = stop - request.start + 1;
  const bool is_shuffled = request.is_shuffled && request.epochs > 1;
  if (is_shuffled && count > UINT32_MAX)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "the range of samples is too long to be shuffled",
                 .offered = std::to_string(count) + " samples",
                 .needed = "at most " + std::to_string(UINT32_MAX),
                 .fix = "is-shuffle=false"};
  SampleOrder out;
  out.first_ = request.start;
  out.count_ = count;
  out.passes_left_ = request.epochs;
  out.is_shuffled_ = is_shuffled;
  out.random_.seed(request.seed != 0 ? request.seed : std::random_device{}());
  return out;
}

std::optional<uint64_t> SampleOrder::next() {
  if (passes_left_ > 0 && at_ == count_) begin_pass();
  if (passes_left_ == 0) return std::nullopt;
  const uint64_t at = at_++;
  return first_ + (shuffled_.empty() ? at : shuffled_[at]);
}

// Begins the next pass, for which each entry of the list is swapped with a random one. The list is
// that of the pass before.
void SampleOrder::begin_pass() {
  at_ = 0;
  if (--passes_left_ == 0 || !is_shuffled_) return;
  if (shuffled_.empty()) {
    shuffled_.resize(count_);
    std::iota(shuffled_.begin(), shuffled_.end(), 0u);
  }
  for (auto& entry : shuffled_) std::swap(entry, shuffled_[random_() % count_]);
}

}  // namespace weir::dataset
