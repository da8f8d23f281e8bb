// SPDX-License-Identifier: LGPL-2.1-or-later
#include "evaluate/comparison.hpp"

#include <cmath>

#include "evaluate/progress_bar.hpp"
#include "run/html.hpp"

namespace weir::app {
namespace {

using evaluate::Interval;
using Rows = std::vector<std::vector<std::string>>;

Json number_json(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}
Json interval_json(const Interval& interval) {
  return Json::array({number_json(interval.low), number_json(interval.high)});
}

Json scores_json(const evaluate::Scores& scores) {
  Json out = Json::object();
  for (const auto& [name, value] : scores) out[name] = number_json(value);
  return out;
}

Json to_json(const Evaluated& one) {
  const Evaluation& evaluation = one.evaluation;
  Json intervals = Json::object();
  for (size_t i = 0; i < one.intervals.size(); ++i)
    intervals[evaluation.scores[i].name] = interval_json(one.intervals[i]);
  Json out{{"name", one.name},
           {"pipeline", one.pipeline},
           {"scores", scores_json(evaluation.scores)},
           {"intervals", intervals},
           {"parts",
            {{"of", evaluation.part_name},
             {"score", evaluation.part_score},
             {"values", scores_json(evaluation.parts)}}}};
  if (!evaluation.confusion.empty()) out["confusion"] = evaluation.confusion;
  return out;
}

std::string score_rows(const EvaluationComparison& comparison) {
  const auto& first = comparison.evaluated[0];
  const bool is_pair = comparison.evaluated.size() > 1;
  Rows rows{{"score", is_pair ? "A" : "value", "95 %"}};
  if (is_pair) rows[0].insert(rows[0].end(), {"B", "95 %", "B - A", "95 %"});
  const auto add = [](const Evaluated& one, size_t i, std::vector<std::string>* row) {
    row->push_back(number_text(one.evaluation.scores[i].value));
    row->push_back(i < one.intervals.size() ? interval_text(one.intervals[i]) : "");
  };
  for (size_t i = 0; i < first.evaluation.scores.size(); ++i) {
    std::vector<std::string> row{first.evaluation.scores[i].name};
    add(first, i, &row);
    if (is_pair) {
      const auto& second = comparison.evaluated[1];
      add(second, i, &row);
      row.push_back(
          number_text(second.evaluation.scores[i].value - first.evaluation.scores[i].value));
      row.push_back(i < comparison.differences.size() ? interval_text(comparison.differences[i])
                                                      : "");
    }
    rows.push_back(std::move(row));
  }
  return table(rows, "");
}

std::string part_rows(const EvaluationComparison& comparison) {
  constexpr size_t kMaxParts = 25;
  const Evaluation& first = comparison.evaluated[0].evaluation;
  if (first.parts.size() < 2) return "";
  Rows rows{{first.part_name, first.part_score}};
  if (comparison.evaluated.size() > 1)
    rows[0] = {first.part_name, first.part_score + " of A", "of B"};
  size_t left_out = 0;
  for (size_t i = 0; i < first.parts.size(); ++i) {
    if (std::isnan(first.parts[i].value)) continue;
    if (rows.size() > kMaxParts) {
      ++left_out;
      continue;
    }
    std::vector<std::string> row{first.parts[i].name, number_text(first.parts[i].value)};
    if (comparison.evaluated.size() > 1)
      for (const auto& part : comparison.evaluated[1].evaluation.parts)
        if (part.name == first.parts[i].name) row.push_back(number_text(part.value));
    rows.push_back(std::move(row));
  }
  std::string out = "\n" + table(rows, "");
  if (left_out > 0) out += "and " + std::to_string(left_out) + " more: --json has all\n";
  return out;
}

}  // namespace

std::string number_text(double value) {
  constexpr int kDigits = 3;
  if (std::isnan(value)) return "-";
  const bool is_count = std::abs(value) > 1 && value == std::floor(value);
  return fixed(value, is_count ? 0 : kDigits);
}

std::string interval_text(const Interval& interval) {
  if (std::isnan(interval.low)) return "-";
  return number_text(interval.low) + " to " + number_text(interval.high);
}

std::string pictures_text(size_t pictures) {
  return std::to_string(pictures) + (pictures == 1 ? " picture" : " pictures");
}

void add_intervals(EvaluationComparison* comparison) {
  auto& all = comparison->evaluated;
  const size_t units = all[0].evaluation.units, scores = all[0].evaluation.headline;
  if (units < 2 || comparison->draws == 0) return;
  if (all.size() > 1 && all[1].evaluation.units != units) return;
  ProgressBar bar(comparison->draws, "draws for the intervals");
  const auto intervals =
      evaluate::bootstrap(units, comparison->draws, comparison->seed, [&](evaluate::Times times) {
        bar.step();
        auto values = all[0].evaluation.measure(times);
        if (all.size() < 2) return values;
        const auto second = all[1].evaluation.measure(times);
        values.insert(values.end(), second.begin(), second.end());
        for (size_t i = 0; i < scores; ++i) values.push_back(second[i] - values[i]);
        return values;
      });
  const auto part = [&](size_t index) {
    const auto begin = intervals.begin() + static_cast<ptrdiff_t>(index * scores);
    return std::vector<Interval>(begin, begin + static_cast<ptrdiff_t>(scores));
  };
  all[0].intervals = part(0);
  if (all.size() < 2) return;
  all[1].intervals = part(1);
  comparison->differences = part(2);
}

std::string verdict(const EvaluationComparison& comparison) {
  const auto& first = comparison.evaluated[0].evaluation.scores[0];
  const double difference = comparison.evaluated[1].evaluation.scores[0].value - first.value;
  if (comparison.differences.empty() || std::isnan(comparison.differences[0].low))
    return "It is not known whether " + first.name + " differs: this needs at least two " +
           comparison.evaluated[0].evaluation.unit_name + ".";
  const auto& [low, high] = comparison.differences[0];
  if (low <= 0 && high >= 0)
    return "The measurement shows no difference in " + first.name + ": 0 is in the interval " +
           interval_text(comparison.differences[0]) + ".";
  return std::string("B is ") + (difference > 0 ? "better" : "worse") + " than A: " + first.name +
         " differs by " + number_text(difference) + ", 95 % " +
         interval_text(comparison.differences[0]) + ".";
}

Json to_json(const EvaluationComparison& comparison) {
  const Evaluation& first = comparison.evaluated[0].evaluation;
  Json out{{"folder", comparison.folder},     {"metric", first.metric},
           {"pictures", comparison.pictures}, {"units", first.units},
           {"unit", first.unit_name},         {"draws", comparison.draws},
           {"seed", comparison.seed},         {"results", Json::array()}};
  for (const auto& one : comparison.evaluated) out["results"].push_back(to_json(one));
  if (comparison.evaluated.size() > 1) {
    Json difference = Json::object();
    const auto& second = comparison.evaluated[1].evaluation;
    for (size_t i = 0; i < first.headline; ++i) {
      Json one{{"value", number_json(second.scores[i].value - first.scores[i].value)}};
      if (i < comparison.differences.size())
        one["interval"] = interval_json(comparison.differences[i]);
      difference[first.scores[i].name] = one;
    }
    out["difference"] = difference;
  }
  out["warnings"] = Json::array();
  for (const Error& warning : comparison.warnings) out["warnings"].push_back(to_json(warning));
  return out;
}

std::string to_text(const EvaluationComparison& comparison) {
  const Evaluation& first = comparison.evaluated[0].evaluation;
  std::string out = first.metric + " of " + pictures_text(comparison.pictures);
  if (first.unit_name != "pictures")
    out += " in " + std::to_string(first.units) + " " + first.unit_name;
  out += ", " + comparison.folder + "\n";
  const bool is_pair = comparison.evaluated.size() > 1;
  if (is_pair)
    out += "A: " + comparison.evaluated[0].name + "\nB: " + comparison.evaluated[1].name + "\n";
  out += "\n" + score_rows(comparison) + part_rows(comparison);
  if (is_pair) out += "\n" + verdict(comparison) + "\n";
  return out;
}

}  // namespace weir::app
