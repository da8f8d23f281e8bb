// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_if/if_settings.hpp"

#include "core/split/pick_list.hpp"

namespace weir {
namespace {

using condition::Behaviour;

Result<condition::Condition> make_condition(const IfSettings& s) {
  return condition::parse_condition(s.compared_value, s.compared_value_option, s.op,
                                    s.supplied_value);
}

struct Way {
  const char* property;
  Behaviour behaviour;
  const std::string* option;
};
std::array<Way, 2> ways(const IfSettings& s) {
  return {Way{"then", s.then_behaviour, &s.then_option},
          Way{"else", s.else_behaviour, &s.else_option}};
}

Result<std::vector<size_t>> picks(const Way& way) {
  if (way.behaviour != Behaviour::TensorPick) return std::vector<size_t>{};
  return parse_index_list(std::string(way.property) + "-option", *way.option, ",");
}

Result<IfBranch> make_branch(const Way& way, const FrameSpec& input) {
  IfBranch branch{way.behaviour, {}, input};
  if (way.behaviour != Behaviour::TensorPick) return branch;
  auto chosen = picks(way);
  if (!chosen) return chosen.error();
  branch.tensors = *std::move(chosen);
  branch.spec.tensors.clear();
  branch.spec.roles = pick_roles(input.roles, branch.tensors);
  if (input.format != Format::Static) return branch;
  for (const size_t index : branch.tensors) {
    if (index >= input.tensors.size())
      return index_beyond(std::string(way.property) + "-option", "tensor", index,
                          input.tensors.size());
    branch.spec.tensors.push_back(input.tensors[index]);
  }
  return branch;
}

Error no_tensors(const std::string& property) {
  return {.code = Code::OPTION_VALUE,
          .what = property + "=TENSORPICK needs a list of tensors",
          .offered = "no " + property + "-option",
          .needed = "a comma list of tensor indices",
          .fix = property + "=TENSORPICK " + property + "-option=0"};
}

}  // namespace

Status check_texts(const IfSettings& settings) {
  if (const auto parsed = make_condition(settings); !parsed) return parsed.error();
  for (const Way& way : ways(settings))
    if (const auto chosen = picks(way); !chosen) return chosen.error();
  return ok();
}

std::optional<Error> missing_setting(const IfSettings& settings) {
  const auto parsed = make_condition(settings);
  if (!parsed) return std::nullopt;
  if (auto error = condition::missing(*parsed)) return error;
  for (const Way& way : ways(settings)) {
    const auto chosen = picks(way);
    if (way.behaviour == Behaviour::TensorPick && chosen && chosen->empty())
      return no_tensors(way.property);
  }
  return std::nullopt;
}

Result<IfPlan> plan_if(const IfSettings& settings, const FrameSpec& input) {
  IfPlan plan;
  const auto parsed = make_condition(settings);
  if (!parsed) return parsed.error();
  if (parsed->compared == condition::ComparedValue::Custom) {
    plan.custom.emplace(parsed->callback);
  } else if (input.format != Format::Static) {
    plan.of_each_frame = *parsed;
  } else {
    auto comparison = condition::Comparison::make(*parsed, input.tensors);
    if (!comparison) return comparison.error();
    plan.comparison = *std::move(comparison);
  }
  for (size_t i = 0; i < 2; ++i) {
    auto branch = make_branch(ways(settings)[i], input);
    if (!branch) return branch.error();
    plan.branches[i] = *std::move(branch);
  }
  return plan;
}

}  // namespace weir
