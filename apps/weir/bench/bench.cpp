// `weir bench MODEL`: measures the model on every engine, thread count and batch size that it
// supports, and prints the fastest pipeline.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstdio>
#include <optional>
#include <tuple>

#include "bench/bench_plan.hpp"
#include "commands.hpp"
#include "core/card/card.hpp"
#include "core/infer/model/model.hpp"
#include "core/infer/module/model_file.hpp"
#include "core/infer/module/module_library.hpp"
#include "doctor/machine_info.hpp"
#include "evaluate/progress_bar.hpp"
#include "inspect/command_error.hpp"
#include "inspect/launch_line.hpp"
#include "inspect/model_card.hpp"
#include "inspect/model_paths.hpp"
#include "inspect/synthetic_inputs.hpp"
#include "models/catalogue.hpp"
#include "report.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

constexpr int kRounds = 3;

double get_median(const BenchCase& one, double Measured::*part) {
  std::vector<double> values;
  for (const auto& round : one.rounds) values.push_back(round.*part);
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

bool ran(const BenchCase& one) {
  return !one.error && !one.rounds.empty();
}

constexpr std::string_view kNotLowered = "none: ";

bool is_lowered(const BenchCase& one) {
  if (one.rounds.empty()) return false;
  const auto& lowering = one.rounds[0].lowering;
  return !lowering.empty() && !lowering.starts_with(kNotLowered);
}

// The engine's name for a table: an engine may lower the graph and have another engine run it.
std::string engine_cell(const BenchCase& one) {
  if (!is_lowered(one)) return one.engine;
  const auto& runner = one.rounds[0].lowering;
  return one.engine + (runner == one.engine ? " (lowered)" : " (lowered to " + runner + ")");
}

// Whether an option that bench added for comparison does not change how the model runs.
bool has_no_effect(const BenchOptions& options, const BenchCase& one, const Measured& measured) {
  return one.custom != options.custom && measured.lowering.starts_with(kNotLowered);
}

UnusableEngine no_effect(const BenchCase& one, const Measured& measured) {
  return {one.engine + ", " + one.custom,
          {.code = Code::MODEL_UNSUPPORTED,
           .what = "the option changes nothing for this model",
           .offered = one.custom,
           .needed = "a graph whose operators can all be lowered",
           .difference = measured.lowering.substr(kNotLowered.size()),
           .fix = "omit the option"}};
}

// Whether the error of one case also applies to another, which then need not run.
bool shares_error(const BenchCase& failed, const BenchCase& other) {
  if (failed.engine != other.engine) return false;
  switch (failed.error->code) {
    case Code::BATCH_UNSUPPORTED:
      return failed.batch == other.batch;
    case Code::ENGINE_UNKNOWN:
    case Code::ENGINE_NOT_INSTALLED:
    case Code::MODULE_REFUSED:
    case Code::MODEL_NOT_FOUND:
    case Code::MODEL_INVALID:
      return true;
    default:
      return false;
  }
}

BenchCaseOptions make_request(const BenchOptions& options, const BenchCase& one) {
  BenchCaseOptions request;
  request.model = options.model;
  request.engine = one.engine;
  request.custom = one.custom;
  request.tensors = options.tensors;
  request.threads = one.threads;
  request.batch = one.batch;
  request.seconds = options.seconds / kRounds;
  request.timeout = options.timeout;
  return request;
}

// Measures one case for one round. Its error applies to every case that shares it, and an option
// without effect drops every case with this option.
void run_round(const BenchOptions& options, BenchCase& one, BenchPlan* plan) {
  const auto measured = run_case(make_request(options, one));
  if (!measured) {
    one.error = measured.error();
    for (auto& other : plan->cases)
      if (!other.error && shares_error(one, other)) other.error = one.error;
  } else if (has_no_effect(options, one, *measured)) {
    plan->refused.push_back(no_effect(one, *measured));
    for (auto& other : plan->cases)
      other.is_dropped |= other.engine == one.engine && other.custom == one.custom;
  } else {
    one.rounds.push_back(*measured);
  }
}

std::vector<const BenchCase*> by_time(const std::vector<BenchCase>& cases) {
  std::vector<const BenchCase*> out;
  for (const auto& one : cases)
    if (ran(one)) out.push_back(&one);
  std::stable_sort(out.begin(), out.end(), [](const auto* a, const auto* b) {
    return get_median(*a, &Measured::ms) < get_median(*b, &Measured::ms);
  });
  return out;
}

// Of the cases within measurement noise of the fastest, returns the one with the lowest cost: small
// batches, few threads, default options.
const BenchCase& find_best(const std::vector<const BenchCase*>& ordered) {
  constexpr double kAlike = 1.05;
  const double limit = get_median(*ordered[0], &Measured::ms) * kAlike;
  const auto cost = [](const BenchCase* one) {
    return std::tuple(one->batch, one->threads, one->custom.size());
  };
  const auto* best = ordered[0];
  for (const auto* one : ordered)
    if (get_median(*one, &Measured::ms) <= limit && cost(one) < cost(best)) best = one;
  return *best;
}

std::string make_name(const BenchCase& one) {
  std::string out = engine_cell(one) + ", threads " + std::to_string(one.threads) + ", batch " +
                    std::to_string(one.batch);
  return one.custom.empty() ? out : out + ", " + one.custom;
}

// Alternates the cases in rounds, so that other load on the machine affects all of them alike.
void run(const BenchOptions& options, BenchPlan* plan) {
  ProgressBar progress(plan->cases.size() * kRounds, "measurements");
  for (int round = 0; round < kRounds; ++round) {
    for (auto& one : plan->cases) {
      progress.show(make_name(one));
      if (!one.error && !one.is_dropped) run_round(options, one, plan);
      progress.step();
    }
    std::erase_if(plan->cases, [](const BenchCase& one) { return one.is_dropped; });
  }
}

// All cases of an engine that failed with the same error.
struct Failure {
  std::string cases;
  Error error;
};
std::vector<Failure> get_failures(const BenchPlan& plan) {
  std::vector<Failure> out;
  for (const auto& refusal : plan.refused) out.push_back({refusal.cases, refusal.error});
  std::vector<const BenchCase*> shown;
  for (const auto& one : plan.cases) {
    if (!one.error) continue;
    const std::string message = one.error->message();
    const auto alike = [&](const BenchCase& other) {
      return other.engine == one.engine && other.error && other.error->message() == message;
    };
    if (std::any_of(shown.begin(), shown.end(), [&](const auto* other) { return alike(*other); }))
      continue;
    shown.push_back(&one);
    const auto all = [&](auto belongs) {
      return std::all_of(plan.cases.begin(), plan.cases.end(), [&](const BenchCase& other) {
        return other.engine != one.engine || !belongs(other) || alike(other);
      });
    };
    std::string cases = make_name(one);
    if (all([](const BenchCase&) { return true; }))
      cases = one.engine;
    else if (all([&](const BenchCase& other) { return other.batch == one.batch; }))
      cases = one.engine + ", batch " + std::to_string(one.batch);
    else if (all([&](const BenchCase& other) { return other.custom == one.custom; }))
      cases = one.engine + ", " + (one.custom.empty() ? "its default options" : one.custom);
    out.push_back({cases, *one.error});
  }
  return out;
}

std::string make_properties(const BenchCase& one, const TensorOptions& tensors) {
  std::string out = "threads=" + std::to_string(one.threads);
  if (!tensors.pairs().empty()) out += " " + property_text(tensors);
  if (one.batch > 1) out += " batch-size=" + std::to_string(one.batch);
  if (!one.custom.empty()) out += " custom=" + launch_value(one.custom);
  return out;
}

Result<LaunchLine> make_line(const BenchOptions& options, const BenchCase& fastest,
                             const Result<card::Card>& given) {
  const auto engine = infer::ModuleLibrary::instance().engine(fastest.engine);
  if (!engine) return engine.error();
  infer::OpenOptions request;
  request.paths = split_paths(options.model);
  request.declared = options.tensors.pairs();
  const auto model = infer::Model::open(**engine, request);
  if (!model) return model.error();
  auto inputs = (*model)->inputs();
  if (inputs.empty() || !options.tensors.input.empty()) {
    auto chosen = inputs_of_frame(std::move(inputs), options.tensors);
    if (!chosen) return chosen.error();
    inputs = *std::move(chosen);
  }
  const auto card = options.card.empty() ? make_card(options.model, **model) : given;
  auto line = launch_line(options.model, fastest.engine, inputs,
                          card ? card::preparation(card->inputs[0]) : "",
                          make_properties(fastest, options.tensors));
  if (!card && card.error().code == Code::CARD_INVALID)
    line.notes.push_back("pixels are not prepared: " + card.error().message());
  if (is_lowered(fastest))
    line.notes.push_back(
        "lowered: Weir translated the graph for " + fastest.rounds[0].lowering +
        ". Its results can differ slightly from those of the engine that the file is made for:"
        " compare them before you rely on it");
  if (fastest.batch > 1)
    line.notes.push_back("batch-size collects frames: each frame waits for " +
                         std::to_string(fastest.batch - 1) + " others");
  return line;
}

Json to_json(const BenchCase& one) {
  const double ms = get_median(one, &Measured::ms);
  return {{"engine", one.engine},
          {"threads", one.threads},
          {"batch", one.batch},
          {"custom", one.custom},
          {"lowered_to", is_lowered(one) ? Json(one.rounds[0].lowering) : Json(nullptr)},
          {"ms", ms},
          {"ms_10_percent", get_median(one, &Measured::low_ms)},
          {"ms_90_percent", get_median(one, &Measured::high_ms)},
          {"frames_per_second", 1e3 / ms},
          {"load_ms", get_median(one, &Measured::load_ms)},
          {"memory_mib", get_median(one, &Measured::mib)}};
}

std::string decimals(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

std::string ms_text(double ms) {
  return decimals(ms, ms < 0.01 ? 6 : ms < 1 ? 4 : 2);
}

std::string indented(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '\n' ? std::string("\n    ") : std::string(1, c);
  return out;
}

void print_text(const BenchOptions& options, const BenchPlan& plan,
                const std::vector<const BenchCase*>& ordered, const LaunchLine& line) {
  const auto machine = get_machine_info();
  std::printf("Model   %s\nCPU     %s, %d %s\n\n", options.model.c_str(), machine.processor.c_str(),
              machine.cores, machine.cores == 1 ? "core" : "cores");
  std::vector<std::vector<std::string>> rows{{"engine", "threads", "batch", "options",
                                              "ms per frame", "10 %", "90 %", "frames/s", "load ms",
                                              "MiB"}};
  for (const auto* one : ordered) {
    const double ms = get_median(*one, &Measured::ms);
    rows.push_back({engine_cell(*one), std::to_string(one->threads), std::to_string(one->batch),
                    one->custom.empty() ? "-" : one->custom, ms_text(ms),
                    ms_text(get_median(*one, &Measured::low_ms)),
                    ms_text(get_median(*one, &Measured::high_ms)), decimals(1e3 / ms, 1),
                    decimals(get_median(*one, &Measured::load_ms), 0),
                    decimals(get_median(*one, &Measured::mib), 1)});
  }
  std::printf("%s", table(rows, "  ").c_str());
  const auto failed = get_failures(plan);
  if (!failed.empty() || !plan.unrelated.empty()) std::printf("\nNot measured\n");
  for (const auto& failure : failed)
    std::printf("  %s\n    %s\n", failure.cases.c_str(), indented(failure.error.message()).c_str());
  const std::string others = join(plan.unrelated, ", ");
  if (!others.empty()) std::printf("  for other files: %s\n", others.c_str());
  std::printf("\nThe fastest: %s\n  %s\n", make_name(find_best(ordered)).c_str(),
              line.command.c_str());
  for (const auto& note : line.notes) std::printf("  note: %s\n", note.c_str());
}

void print_json(const BenchOptions& options, const BenchPlan& plan,
                const std::vector<const BenchCase*>& ordered, const LaunchLine& line) {
  const auto machine = get_machine_info();
  Json out{{"model", options.model},
           {"cpu", {{"name", machine.processor}, {"cores", machine.cores}}},
           {"cases", Json::array()},
           {"not_measured", Json::array()}};
  for (const auto* one : ordered) out["cases"].push_back(to_json(*one));
  for (const auto& failure : get_failures(plan))
    out["not_measured"].push_back(
        {{"case", failure.cases}, {"error", app::to_json(failure.error)}});
  out["for_other_files"] = plan.unrelated;
  out["fastest"] = to_json(find_best(ordered));
  out["launch"] = line.command;
  out["notes"] = line.notes;
  print(out);
}

// The error of a path that is a folder or does not exist; empty for an address.
std::optional<Error> missing_file(const std::string& model) {
  const Status found = infer::check_model_file(split_paths(model).front());
  if (found || model.find("://") != std::string::npos) return std::nullopt;
  return found.error();
}

// The error when no case ran.
Error nothing_ran(const BenchOptions& options, const BenchPlan& plan) {
  auto failed = get_failures(plan);
  if (const auto no_file = missing_file(options.model); failed.empty() && no_file) return *no_file;
  if (failed.empty())
    return {.code = Code::ENGINE_UNKNOWN,
            .what = "no engine can be selected for this model",
            .offered = options.model,
            .needed = "a file with the extension .onnx, .tflite, ...",
            .fix = "weir bench --engine NAME " + shell_word(options.model)};
  Error error = failed[0].error;
  for (size_t i = 1; i < failed.size(); ++i)
    error.difference +=
        (error.difference.empty() ? "" : "; ") + failed[i].cases + ": " + failed[i].error.what;
  return error;
}

}  // namespace

int bench(const BenchOptions& given) {
  BenchOptions options = given;
  const auto file = file_of_model(given.model);
  if (!file) return report(file.error(), given.json);
  options.model = *file;
  Result<card::Card> card = Error{};
  if (!options.card.empty()) {
    card = card::read(options.card);
    if (!card) return report(command_error(card.error()), options.json);
  }
  auto plan = plan_bench(options);
  if (!plan) return report(plan.error(), options.json);
  run(options, &*plan);
  const auto ordered = by_time(plan->cases);
  if (ordered.empty()) return report(command_error(nothing_ran(options, *plan)), options.json);
  const auto line = make_line(options, find_best(ordered), card);
  if (!line) return report(line.error(), options.json);
  if (options.json)
    print_json(options, *plan, ordered, *line);
  else
    print_text(options, *plan, ordered, *line);
  return kExitGood;
}

}  // namespace weir::app
