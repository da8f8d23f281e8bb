// The element-wise chain: the scalar kernel, and the choice of how channels are processed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/chain.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "core/transform/chain_program.hpp"
#include "core/transform/number_rules.hpp"

namespace weir::transform {
namespace {

template <class T>
T load(const std::byte* from) noexcept {
  T value;
  std::memcpy(&value, from, sizeof(T));
  return value;
}

template <class T>
T apply(Operator op, T x, T operand) noexcept {
  switch (op) {
    case Operator::Add:
      return add<T>(x, operand);
    case Operator::Mul:
      return mul<T>(x, operand);
    case Operator::Div:
      break;
  }
  return div<T>(x, operand);
}

// The reference implementation, element by element. All others must produce these results.
template <class From, class To>
void run_plain(std::span<const TypedStep> steps, const Channels& channels, const std::byte* in,
               std::byte* out, size_t count) noexcept {
  for (size_t i = 0; i < count; ++i) {
    To x = convert<To>(load<From>(in + i * sizeof(From)));
    const size_t channel = channels.count == 1 ? 0 : i / channels.inner % channels.count;
    for (const auto& step : steps)
      if (step.touches(channel)) x = apply<To>(step.op, x, step.operand_as<To>());
    std::memcpy(out + i * sizeof(To), &x, sizeof(To));
  }
}

using PlainRunner = void (*)(std::span<const TypedStep>, const Channels&, const std::byte*,
                             std::byte*, size_t) noexcept;

PlainRunner plain_runner(ElementType from, ElementType to) noexcept {
  return visit_type(from, [to](auto from_tag) {
    return visit_type(to, [](auto to_tag) -> PlainRunner {
      return run_plain<typename decltype(from_tag)::type, typename decltype(to_tag)::type>;
    });
  });
}

// The common parts of every chain: sizes, steps, and the divisions that are skipped.
struct ChainParts {
  ElementType from, to;
  size_t count;  // elements of the tensor
  Channels channels;
  std::vector<TypedStep> steps;           // without integer divisions by zero
  std::vector<TypedStep> zero_divisions;  // leave each element unchanged and are counted
};

// The number of elements with this channel among the first `count`.
uint64_t elements_of_channel(const Channels& channels, uint32_t channel, size_t count) noexcept {
  if (channel >= channels.count) return 0;
  const size_t period = channels.inner * channels.count;
  const size_t begin = channel * channels.inner;
  const size_t rest = count % period;
  const size_t partial = rest > begin ? std::min(rest - begin, channels.inner) : 0;
  return uint64_t{count / period} * channels.inner + partial;
}

std::shared_ptr<const Kernel> make_kernel(ChainParts parts, bool accelerate);

bool names_channels(const ChainParts& parts) noexcept {
  const auto named = [](const TypedStep& step) { return step.channel.has_value(); };
  return std::any_of(parts.steps.begin(), parts.steps.end(), named) ||
         std::any_of(parts.zero_divisions.begin(), parts.zero_divisions.end(), named);
}
bool same_channels(const ChainParts& one, const ChainParts& two) noexcept {
  return one.channels.inner == two.channels.inner && one.channels.count == two.channels.count;
}

class ChainKernel : public Kernel {
 public:
  ChainKernel(ChainParts parts, bool accelerated)
      : parts_(std::move(parts)), accelerated_(accelerated) {}

  Counters run(std::span<const std::byte> in, std::span<std::byte> out) const noexcept final {
    const size_t count = std::min({parts_.count, in.size() / element_size(parts_.from),
                                   out.size() / element_size(parts_.to)});
    if (count == 0) return {};
    compute(in.data(), out.data(), count);
    Counters counters;
    for (const auto& step : parts_.zero_divisions)
      counters.divisions_by_zero +=
          step.channel ? elements_of_channel(parts_.channels, *step.channel, count) : count;
    return counters;
  }
  bool in_place_possible() const noexcept final {
    return element_size(parts_.from) == element_size(parts_.to);
  }
  size_t period() const noexcept final { return parts_.channels.inner * parts_.channels.count; }

  std::shared_ptr<const Kernel> followed_by(const Kernel& second) const final {
    const auto* next = dynamic_cast<const ChainKernel*>(&second);
    if (!next || next->accelerated_ != accelerated_ || next->parts_.from != next->parts_.to ||
        next->parts_.from != parts_.to || next->parts_.count != parts_.count)
      return nullptr;
    ChainParts both = parts_;
    if (!names_channels(both)) {
      both.channels = next->parts_.channels;
    } else if (names_channels(next->parts_) && !same_channels(both, next->parts_)) {
      return nullptr;
    }
    const auto append = [](std::vector<TypedStep>& to, const std::vector<TypedStep>& steps) {
      to.insert(to.end(), steps.begin(), steps.end());
    };
    append(both.steps, next->parts_.steps);
    append(both.zero_divisions, next->parts_.zero_divisions);
    return make_kernel(std::move(both), accelerated_);
  }

 protected:
  const ChainParts& parts() const noexcept { return parts_; }

 private:
  virtual void compute(const std::byte* in, std::byte* out, size_t count) const noexcept = 0;
  ChainParts parts_;
  bool accelerated_;
};

class PlainChain final : public ChainKernel {
 public:
  explicit PlainChain(ChainParts parts)
      : ChainKernel(std::move(parts), false),
        runner_(plain_runner(this->parts().from, this->parts().to)) {}

 private:
  void compute(const std::byte* in, std::byte* out, size_t count) const noexcept override {
    runner_(parts().steps, parts().channels, in, out, count);
  }
  PlainRunner runner_;
};

ChainRunner vector_runner(ElementType from, ElementType to) noexcept {
  return fused_to_float(from, to) ? run_chain_float : run_chain_blocks;
}

// One program with the channels inside its period.
class VectorChain final : public ChainKernel {
 public:
  explicit VectorChain(ChainParts parts)
      : ChainKernel(std::move(parts), true),
        program_(make_chain_program(this->parts().from, this->parts().to, this->parts().steps,
                                    this->parts().channels)),
        runner_(vector_runner(this->parts().from, this->parts().to)) {}

 private:
  void compute(const std::byte* in, std::byte* out, size_t count) const noexcept override {
    runner_(program_, in, out, count, parts().from, parts().to);
  }
  ChainProgram program_;
  ChainRunner runner_;
};

// For channels in long runs: one program for each channel that a step names, one for all others.
class RunwiseChain final : public ChainKernel {
 public:
  explicit RunwiseChain(ChainParts parts)
      : ChainKernel(std::move(parts), true),
        runner_(vector_runner(this->parts().from, this->parts().to)) {
    std::vector<uint32_t> named;
    for (const auto& step : this->parts().steps)
      if (step.channel && *step.channel < this->parts().channels.count)
        named.push_back(*step.channel);
    std::sort(named.begin(), named.end());
    named.erase(std::unique(named.begin(), named.end()), named.end());
    for (const uint32_t channel : named) programs_.push_back({channel, make_program(channel)});
    other_ = make_program(std::nullopt);
  }

 private:
  ChainProgram make_program(std::optional<uint32_t> channel) const {
    std::vector<TypedStep> steps;
    for (auto step : parts().steps) {
      if (step.channel && step.channel != channel) continue;
      step.channel.reset();
      steps.push_back(step);
    }
    return make_chain_program(parts().from, parts().to, steps, Channels{});
  }

  const ChainProgram& program_for(uint32_t channel) const noexcept {
    const auto found = std::lower_bound(
        programs_.begin(), programs_.end(), channel,
        [](const auto& program, uint32_t wanted) { return program.first < wanted; });
    return found != programs_.end() && found->first == channel ? found->second : other_;
  }

  void compute(const std::byte* in, std::byte* out, size_t count) const noexcept override {
    const auto [inner, channels] = parts().channels;
    const size_t in_bytes = element_size(parts().from), out_bytes = element_size(parts().to);
    uint32_t channel = 0;
    for (size_t i = 0; i < count; i += inner) {
      runner_(program_for(channel), in + i * in_bytes, out + i * out_bytes,
              std::min(inner, count - i), parts().from, parts().to);
      if (++channel == channels) channel = 0;
    }
  }

  std::vector<std::pair<uint32_t, ChainProgram>> programs_;  // in ascending order of channels
  ChainProgram other_;
  ChainRunner runner_;
};

std::shared_ptr<const Kernel> make_kernel(ChainParts parts, bool accelerate) {
  if (!accelerate) return std::make_shared<PlainChain>(std::move(parts));
  constexpr size_t kTableLimit = 1 << 18;  // a larger period is not worth a table
  const auto [inner, channels] = parts.channels;
  if (channels > 1 && inner >= kChainBlock) return std::make_shared<RunwiseChain>(std::move(parts));
  if (inner > kTableLimit / channels) return std::make_shared<PlainChain>(std::move(parts));
  return std::make_shared<VectorChain>(std::move(parts));
}

TypedStep typed(const ArithmeticStep& step, ElementType to, bool by_channel) {
  TypedStep out;
  out.op = step.op;
  if (by_channel) out.channel = step.channel;
  visit_type(to, [&](auto tag) {
    using T = typename decltype(tag)::type;
    const T operand =
        std::visit([](auto value) { return convert_operand<T>(value); }, step.operand);
    std::memcpy(out.operand, &operand, sizeof(T));
  });
  return out;
}

bool is_integer(ElementType type) noexcept {
  return visit_type(type, [](auto tag) { return std::integral<typename decltype(tag)::type>; });
}

Channels get_channels(const Shape& shape, size_t dimension) noexcept {
  Channels channels;
  for (size_t i = 0; i < std::min(dimension, shape.rank()); ++i) channels.inner *= shape[i];
  if (dimension < shape.rank()) channels.count = shape[dimension];
  return channels;
}

ChainParts make_parts(const TensorSpec& in, ElementType to, std::span<const ArithmeticStep> steps,
                      std::optional<size_t> channel_dimension) {
  ChainParts parts{in.type, to, static_cast<size_t>(in.shape.count().value_or(0)), {}, {}, {}};
  const bool by_channel =
      channel_dimension && std::any_of(steps.begin(), steps.end(),
                                       [](const auto& step) { return step.channel.has_value(); });
  if (by_channel) parts.channels = get_channels(in.shape, *channel_dimension);
  constexpr std::byte kZero[8] = {};
  for (const auto& step : steps) {
    const auto typed_step = typed(step, to, by_channel);
    const bool by_zero = step.op == Operator::Div && is_integer(to) &&
                         std::memcmp(typed_step.operand, kZero, sizeof(kZero)) == 0;
    (by_zero ? parts.zero_divisions : parts.steps).push_back(typed_step);
  }
  return parts;
}

}  // namespace

std::shared_ptr<const Kernel> make_chain_kernel(const TensorSpec& in, ElementType to,
                                                std::span<const ArithmeticStep> steps,
                                                std::optional<size_t> channel_dimension,
                                                bool accelerate) {
  auto parts = make_parts(in, to, steps, channel_dimension);
  if (in.type == to && steps.empty())
    return std::make_shared<CopyKernel>(parts.count * element_size(to), element_size(to));
  return make_kernel(std::move(parts), accelerate);
}

}  // namespace weir::transform
