// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/evaluate/average_precision.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "core/evaluate/similarity.hpp"

namespace weir::evaluate {
namespace {

struct AreaRange {
  double min, max;
};
constexpr AreaRange kAreas[] = {
    {0, 1e10}, {0, 32.0 * 32}, {32.0 * 32, 96.0 * 96}, {96.0 * 96, 1e10}};
enum Range : size_t { kAll, kSmall, kMedium, kLarge, kRanges };
constexpr double kFar = std::numeric_limits<double>::max();
constexpr size_t kHalf = 0, kThreeQuarters = 5;  // indices of the thresholds .50 and .75

// The thresholds as NumPy's linspace(.5, .95, 10) rounds them.
double threshold_at(size_t index) noexcept {
  constexpr double kFirst = .5, kLast = .95;
  if (index + 1 == kSimilarityThresholds) return kLast;
  return kFirst + static_cast<double>(index) * ((kLast - kFirst) / (kSimilarityThresholds - 1));
}

// The area of the box around the points.
double area_of_points(const std::vector<LabelledPoint>& points) noexcept {
  double left = kFar, top = kFar, right = -kFar, bottom = -kFar;
  for (const LabelledPoint& point : points) {
    if (!point.is_labelled) continue;
    left = std::min(left, point.x);
    right = std::max(right, point.x);
    top = std::min(top, point.y);
    bottom = std::max(bottom, point.y);
  }
  return left <= right ? (right - left) * (bottom - top) : 0;
}

bool is_in(const AreaRange& range, double area) noexcept {
  return area >= range.min && area <= range.max;
}

}  // namespace

// Matches the objects of one category in one picture, for all ranges and thresholds.
struct AveragePrecision::Matcher {
  const AveragePrecision& owner;
  const PrecisionSettings& settings;
  std::vector<const TruthObject*> truth;
  std::vector<const FoundObject*> found;  // by falling score
  std::vector<std::vector<double>> similarities;

  Matcher(const AveragePrecision& precision, const PrecisionSettings& how,
          const PictureObjects& picture, size_t category)
      : owner(precision), settings(how) {
    for (const auto& object : picture.truth)
      if (object.category == category) truth.push_back(&object);
    for (const auto& object : picture.found)
      if (object.category == category) found.push_back(&object);
    std::stable_sort(found.begin(), found.end(),
                     [](const auto* a, const auto* b) { return a->score > b->score; });
    if (found.size() > owner.max_found_) found.resize(owner.max_found_);
    for (const auto* object : found) {
      auto& row = similarities.emplace_back();
      for (const auto* other : truth) row.push_back(similarity(*object, *other));
    }
  }

  double similarity(const FoundObject& object, const TruthObject& other) const {
    if (owner.has_key_points_) return key_point_similarity(other, object, settings.deviations);
    return other.is_crowd ? part_in_crowd(object.box, other.box) : overlap(object.box, other.box);
  }

  void add_to(Slice* slice, uint32_t picture, const AreaRange& range) const {
    std::vector<bool> ignored;
    for (const auto* object : truth)
      ignored.push_back(object->is_ignored || object->is_crowd || !is_in(range, object->area));
    const auto counted = std::count(ignored.begin(), ignored.end(), false);
    if (counted > 0) slice->positives.push_back({picture, static_cast<uint32_t>(counted)});
    // Objects that count are matched first.
    std::vector<size_t> order(truth.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::stable_partition(order.begin(), order.end(), [&](size_t i) { return !ignored[i]; });
    std::vector<Candidate> candidates(found.size());
    for (size_t t = 0; t < kSimilarityThresholds; ++t)
      match_at(t, ignored, order, range, &candidates);
    for (size_t d = 0; d < found.size(); ++d) {
      candidates[d].picture = picture;
      candidates[d].rank = static_cast<uint32_t>(d);
      candidates[d].score = found[d]->score;
      slice->candidates.push_back(candidates[d]);
    }
  }

  void match_at(size_t threshold, const std::vector<bool>& ignored,
                const std::vector<size_t>& order, const AreaRange& range,
                std::vector<Candidate>* candidates) const {
    const auto bit = static_cast<uint16_t>(1U << threshold);
    std::vector<bool> is_taken(truth.size(), false);
    for (size_t d = 0; d < found.size(); ++d) {
      const auto match = best_match(d, threshold_at(threshold), ignored, order, is_taken);
      Candidate& candidate = (*candidates)[d];
      if (match) {
        is_taken[*match] = true;
        candidate.matched |= bit;
        if (ignored[*match]) candidate.ignored |= bit;
        continue;
      }
      const double area =
          owner.has_key_points_ ? area_of_points(found[d]->points) : found[d]->box.area();
      if (!is_in(range, area)) candidate.ignored |= bit;
    }
  }

  // A crowd may be matched many times. An ignored object is matched only if none that counts is.
  std::optional<size_t> best_match(size_t d, double min, const std::vector<bool>& ignored,
                                   const std::vector<size_t>& order,
                                   const std::vector<bool>& is_taken) const {
    std::optional<size_t> match;
    double best = std::min(min, 1 - 1e-10);
    for (const size_t g : order) {
      if (is_taken[g] && !truth[g]->is_crowd) continue;
      if (match && !ignored[*match] && ignored[g]) break;
      if (similarities[d][g] < best) continue;
      best = similarities[d][g];
      match = g;
    }
    return match;
  }
};

namespace {

std::set<size_t> list_categories(const PictureObjects& picture) {
  std::set<size_t> out;
  for (const auto& object : picture.truth) out.insert(object.category);
  for (const auto& object : picture.found) out.insert(object.category);
  return out;
}

}  // namespace

AveragePrecision::AveragePrecision(std::span<const PictureObjects> pictures, size_t categories,
                                   const PrecisionSettings& settings)
    : has_key_points_(!settings.deviations.empty()), max_found_(has_key_points_ ? 20 : 100) {
  slices_.resize(kRanges, std::vector<Slice>(categories));
  for (size_t p = 0; p < pictures.size(); ++p) {
    for (const size_t c : list_categories(pictures[p])) {
      const Matcher matcher(*this, settings, pictures[p], c);
      for (size_t range = 0; range < kRanges; ++range)
        matcher.add_to(&slices_[range][c], static_cast<uint32_t>(p), kAreas[range]);
    }
  }
  for (auto& categories_of_range : slices_)
    for (auto& slice : categories_of_range)
      std::stable_sort(slice.candidates.begin(), slice.candidates.end(),
                       [](const auto& a, const auto& b) { return a.score > b.score; });
}

double AveragePrecision::count_positives(const Slice& slice, Times times) {
  uint64_t out = 0;
  for (const auto& [picture, count] : slice.positives)
    out += uint64_t{count} * count_times(times, picture);
  return static_cast<double>(out);
}

AveragePrecision::Curve AveragePrecision::curve(const Slice& slice, size_t threshold, uint32_t max,
                                                Times times) const {
  Curve out;
  const double positives = count_positives(slice, times);
  if (positives == 0) return out;
  out.is_defined = true;
  std::vector<double> recalls, precisions;
  recalls.reserve(slice.candidates.size());
  precisions.reserve(slice.candidates.size());
  double hits = 0, misses = 0;
  for (const Candidate& candidate : slice.candidates) {
    if (candidate.rank >= max || (candidate.ignored >> threshold & 1) != 0) continue;
    const bool is_hit = (candidate.matched >> threshold & 1) != 0;
    for (uint32_t i = count_times(times, candidate.picture); i > 0; --i) {
      (is_hit ? hits : misses) += 1;
      recalls.push_back(hits / positives);
      precisions.push_back(hits / (hits + misses));
    }
  }
  if (recalls.empty()) return out;
  out.recall = recalls.back();
  set_precisions(recalls, std::move(precisions), &out);
  return out;
}

// The best precision at each of the 101 recalls or beyond it.
void AveragePrecision::set_precisions(const std::vector<double>& recalls,
                                      std::vector<double> precisions, Curve* curve) {
  for (size_t i = precisions.size() - 1; i > 0; --i)
    precisions[i - 1] = std::max(precisions[i - 1], precisions[i]);
  for (size_t r = 0; r < kRecalls; ++r) {
    const double wanted = r + 1 == kRecalls ? 1.0 : static_cast<double>(r) * 0.01;
    const auto at = std::lower_bound(recalls.begin(), recalls.end(), wanted);
    if (at != recalls.end())
      curve->precision[r] = precisions[static_cast<size_t>(at - recalls.begin())];
  }
}

AveragePrecision::Mean AveragePrecision::mean(size_t range, size_t first_threshold,
                                              size_t end_threshold, uint32_t max,
                                              Times times) const {
  double precision = 0, recall = 0, curves = 0;
  for (const Slice& slice : slices_[range])
    for (size_t t = first_threshold; t < end_threshold; ++t) {
      const Curve one = curve(slice, t, max, times);
      if (!one.is_defined) continue;
      precision += std::accumulate(one.precision.begin(), one.precision.end(), 0.0) / kRecalls;
      recall += one.recall;
      curves += 1;
    }
  return {ratio(precision, curves), ratio(recall, curves)};
}

Scores AveragePrecision::headline(Times times) const {
  std::array<double, kSimilarityThresholds> precisions{};
  for (size_t t = 0; t < kSimilarityThresholds; ++t)
    precisions[t] = mean(kAll, t, t + 1, max_found_, times).precision;
  // Each threshold has the same categories, so the mean of the means is the mean of all.
  const double sum = std::accumulate(precisions.begin(), precisions.end(), 0.0);
  return {{"AP", sum / kSimilarityThresholds},
          {"AP50", precisions[kHalf]},
          {"AP75", precisions[kThreeQuarters]}};
}

Scores AveragePrecision::scores() const {
  Scores out = headline({});
  const auto all = [&](size_t range, uint32_t max) {
    return mean(range, 0, kSimilarityThresholds, max, {});
  };
  const Mean small = all(kSmall, max_found_), medium = all(kMedium, max_found_),
             large = all(kLarge, max_found_), any = all(kAll, max_found_);
  if (has_key_points_) {
    const auto recall_at = [&](size_t t) { return mean(kAll, t, t + 1, max_found_, {}).recall; };
    out.insert(out.end(), {{"AP medium", medium.precision},
                           {"AP large", large.precision},
                           {"AR", any.recall},
                           {"AR50", recall_at(kHalf)},
                           {"AR75", recall_at(kThreeQuarters)},
                           {"AR medium", medium.recall},
                           {"AR large", large.recall}});
    return out;
  }
  out.insert(out.end(), {{"AP small", small.precision},
                         {"AP medium", medium.precision},
                         {"AP large", large.precision},
                         {"AR 1", all(kAll, 1).recall},
                         {"AR 10", all(kAll, 10).recall},
                         {"AR 100", any.recall},
                         {"AR small", small.recall},
                         {"AR medium", medium.recall},
                         {"AR large", large.recall}});
  return out;
}

double AveragePrecision::of_category(size_t category) const {
  double sum = 0;
  for (size_t t = 0; t < kSimilarityThresholds; ++t) {
    const Curve one = curve(slices_[kAll][category], t, max_found_, {});
    if (!one.is_defined) return kUndefined;
    sum += std::accumulate(one.precision.begin(), one.precision.end(), 0.0) / kRecalls;
  }
  return sum / kSimilarityThresholds;
}

std::array<double, kRecalls> AveragePrecision::curve_of_category(size_t category) const {
  return curve(slices_[kAll][category], kHalf, max_found_, {}).precision;
}

}  // namespace weir::evaluate
