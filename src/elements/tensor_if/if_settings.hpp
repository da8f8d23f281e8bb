// IfSettings: the properties of tensor_if, and the plan that they make for a stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/condition/comparison.hpp"
#include "core/condition/custom_condition.hpp"
#include "gstcpp/element/property.hpp"

namespace weir {

struct IfSettings {
  bool silent = true;
  condition::ComparedValue compared_value = condition::ComparedValue::Element;
  std::string compared_value_option;
  condition::Operator op = condition::Operator::Equal;
  std::string supplied_value;
  condition::Behaviour then_behaviour = condition::Behaviour::Passthrough;
  std::string then_option;
  condition::Behaviour else_behaviour = condition::Behaviour::Passthrough;
  std::string else_option;
};

// The behaviour for frames of one branch.
struct IfBranch {
  condition::Behaviour behaviour = condition::Behaviour::Skip;
  std::vector<size_t> tensors;  // for TensorPick
  FrameSpec spec;               // of the output
};

struct IfPlan {
  std::optional<condition::Comparison> comparison;    // or
  std::optional<condition::Condition> of_each_frame;  // in a flexible stream; or
  std::optional<condition::CustomCondition> custom;
  std::array<IfBranch, 2> branches;  // THEN, ELSE: src_0, src_1
};

// Checks the property texts, independently of a stream.
Status check_texts(const IfSettings& settings);
// The error for a required property that is not set.
std::optional<Error> missing_setting(const IfSettings& settings);
// Precondition: missing_setting() returns none.
Result<IfPlan> plan_if(const IfSettings& settings, const FrameSpec& input);

namespace gst {

template <>
struct EnumType<condition::ComparedValue> {
  static GType type() {
    static const GEnumValue values[] = {{0, "A_VALUE", "A_VALUE"},
                                        {3, "TENSOR_AVERAGE_VALUE", "TENSOR_AVERAGE_VALUE"},
                                        {5, "CUSTOM", "CUSTOM"},
                                        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirIfComparedValue", values);
    return t;
  }
};
// "eqaual" is the spelling that users have written since the first release.
template <>
struct EnumType<condition::Operator> {
  static GType type() {
    static const GEnumValue values[] = {{0, "EQ", "eqaual"},
                                        {1, "NE", "not_eqaual"},
                                        {2, "GT", "greater_than"},
                                        {3, "GE", "greater_or_equal"},
                                        {4, "LT", "less_than"},
                                        {5, "LE", "less_or_equal"},
                                        {6, "RANGE_INCLUSIVE", "range inclusive"},
                                        {7, "RANGE_EXCLUSIVE", "range exclusive"},
                                        {8, "NOT_IN_RANGE_INCLUSIVE", "not in range inclusive"},
                                        {9, "NOT_IN_RANGE_EXCLUSIVE", "not in range exclusive"},
                                        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirIfOperator", values);
    return t;
  }
};
template <>
struct EnumType<condition::Behaviour> {
  static GType type() {
    static const GEnumValue values[] = {{0, "PASSTHROUGH", "passthrough"},
                                        {1, "SKIP", "skip"},
                                        {7, "TENSORPICK", "tensorpick"},
                                        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirIfBehaviour", values);
    return t;
  }
};

}  // namespace gst
}  // namespace weir
