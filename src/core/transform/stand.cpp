// mode=stand: its grammar, and the division of a tensor into strips.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/stand.hpp"

#include "core/transform/chain_program.hpp"
#include "core/transform/option_reader.hpp"
#include "core/transform/stand_table.hpp"

namespace weir::transform {
namespace {

constexpr const char* kStandExample = "option=default:float32";

class StandKernel final : public Kernel {
 public:
  StandKernel(const Stand& stand, const TensorSpec& in, ElementType to, bool accelerate) noexcept
      : types_{in.type, to, !stand.only_mean},
        count_(static_cast<size_t>(in.shape.count().value_or(0))),
        channels_(stand.per_channel ? in.shape[0] : 1),
        accelerate_(accelerate) {}

  Counters run(std::span<const std::byte> in, std::span<std::byte> out) const noexcept override {
    if (in.size() < count_ * element_size(types_.from) ||
        out.size() < count_ * element_size(types_.to))
      return {};
    if (const StandTensor tensor{count_, channels_}; measures_few(tensor, types_.from)) {
      run_few(tensor, in.data(), out.data());
      return {};
    }
    if (channels_ <= kChainBlock) {
      run_stand_strip(whole(), types_, nullptr, accelerate_, in.data(), out.data());
      return {};
    }
    for (size_t begin = 0; begin < channels_; begin += kChainBlock) {
      const size_t width = channels_ - begin < kChainBlock ? channels_ - begin : kChainBlock;
      const StandStrip some{begin, width, channels_, count_ / channels_, 0, width};
      run_stand_strip(some, types_, nullptr, accelerate_, in.data(), out.data());
    }
    return {};
  }
  // Only the last pass writes, each element at the place where it was read.
  bool in_place_possible() const noexcept override {
    return element_size(types_.from) == element_size(types_.to);
  }

 private:
  StandStrip whole() const noexcept {
    const size_t width = kChainBlock / channels_ * channels_;
    return {0, width, width, count_ / width, count_ % width, channels_};
  }
  void run_few(const StandTensor& tensor, const std::byte* in, std::byte* out) const noexcept {
    const auto scale = measure_few(tensor, types_, accelerate_, in);
    if (scales_in_float(tensor, types_, scale))
      run_stand_float(tensor, types_, scale, accelerate_, in, out);
    else if (has_stand_table(tensor, types_))
      run_stand_table(tensor, types_, scale, accelerate_, in, out);
    else
      run_stand_strip(whole(), types_, &scale, accelerate_, in, out);
  }

  StandTypes types_;
  size_t count_, channels_;
  bool accelerate_;
};

ElementType type_after(const Stand& stand, ElementType in) noexcept {
  return stand.to == ElementType::End ? in : stand.to;
}

}  // namespace

Result<Operation> parse_stand(std::string_view option) {
  OptionReader reader("stand", option);
  Stand stand;
  if (reader.take("dc-average"))
    stand.only_mean = true;
  else if (!reader.take("default"))
    return reader.syntax_error("default or dc-average", kStandExample);
  if (reader.take(":")) {
    stand.to = reader.take_type();
    if (stand.to == ElementType::End)
      return reader.syntax_error("an element type such as float32", kStandExample);
  }
  if (reader.take(",per-channel:")) {
    stand.per_channel = reader.take("true");
    if (!stand.per_channel && !reader.take("false"))
      return reader.syntax_error("true or false", "option=default:float32,per-channel:true");
  }
  if (!reader.at_end())
    return reader.syntax_error("':' and a type, ',per-channel:true', or the end", kStandExample);
  return Operation{stand, {}};
}

TemplateSpec get_output(const Stand& stand, const TemplateSpec& in) {
  return {type_after(stand, in.type), in.shape};
}

std::optional<TemplateSpec> find_input(const Stand& stand, const TemplateSpec& out) {
  if (stand.to == ElementType::End) return out;
  if (!out.type_open() && out.type != stand.to) return std::nullopt;
  return TemplateSpec{ElementType::End, out.shape};
}

std::shared_ptr<const Kernel> make_kernel(const Stand& stand, const TensorSpec& in,
                                          bool accelerate) {
  return std::make_shared<StandKernel>(stand, in, type_after(stand, in.type), accelerate);
}

}  // namespace weir::transform
