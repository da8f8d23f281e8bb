// mode=clamp: its grammar, and its limits in each element type.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/clamp.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/text/text.hpp"
#include "core/transform/option_reader.hpp"

namespace weir::transform {
namespace {

constexpr const char* kClampExample = "option=-1.0:1.0";

Result<double> take_limit(OptionReader& reader) {
  const size_t begin = reader.position();
  const auto text = reader.take_number();
  if (text.empty()) return reader.syntax_error("a number such as 0, -1.5 or 1e3", kClampExample);
  if (const auto value = parse_double(text)) return *value;
  reader.go_to(begin);
  return reader.value_error("a limit of the clamp is out of range", "a float64", kClampExample);
}

// The next float16 above or below x; x is finite.
float16 next_half(float16 x, bool up) noexcept {
  const bool negative = (x.bits & 0x8000) != 0;
  if ((x.bits & 0x7FFF) == 0)
    x.bits = up ? 0x0001 : 0x8001;
  else
    x.bits = static_cast<uint16_t>(negative == up ? x.bits - 1 : x.bits + 1);
  return x;
}

template <class T>
T next(T x, bool up) noexcept {
  if constexpr (std::is_same_v<T, float16>)
    return next_half(x, up);
  else
    return std::nextafter(
        x, up ? std::numeric_limits<T>::infinity() : -std::numeric_limits<T>::infinity());
}

template <class T>
double as_double(T x) noexcept {
  if constexpr (std::is_same_v<T, float16>)
    return static_cast<double>(static_cast<float>(x));
  else
    return static_cast<double>(x);
}

template <class T>
T rounded(double x) noexcept {
  if constexpr (std::is_same_v<T, float16>)
    return float16(static_cast<float>(x));
  else
    return static_cast<T>(x);
}

// Comparing in T is exact: the limits move to the nearest value of T inside the range.
template <class T>
Limits<T> real_limits(const Clamp& clamp) noexcept {
  Limits<T> out{rounded<T>(clamp.low), rounded<T>(clamp.low), rounded<T>(clamp.high),
                rounded<T>(clamp.high)};
  if (as_double(out.first) < clamp.low) out.first = next(out.first, true);
  if (as_double(out.last) > clamp.high) out.last = next(out.last, false);
  return out;
}

template <class T>
Limits<T> integer_limits(const Clamp& clamp) noexcept {
  constexpr T kMin = std::numeric_limits<T>::min(), kMax = std::numeric_limits<T>::max();
  const double end = std::ldexp(1.0, std::numeric_limits<T>::digits);  // kMax + 1
  const auto nearest = [&](double x) {
    return x >= end ? kMax : x <= static_cast<double>(kMin) ? kMin : static_cast<T>(x);
  };
  const double first = std::ceil(clamp.low), last = std::floor(clamp.high);
  Limits<T> out{nearest(first), nearest(clamp.low), nearest(last), nearest(clamp.high)};
  if (first >= end) return {.low = kMax, .fill = true};
  if (last < static_cast<double>(kMin)) return {.low = kMin, .fill = true};
  return out;
}

class ClampKernel final : public Kernel {
 public:
  ClampKernel(const Clamp& clamp, const TensorSpec& in) noexcept
      : type_(in.type), count_(static_cast<size_t>(in.shape.count().value_or(0))) {
    visit_type(type_, [&](auto tag) {
      using T = typename decltype(tag)::type;
      Limits<T> limits;
      if constexpr (std::is_integral_v<T>)
        limits = integer_limits<T>(clamp);
      else
        limits = real_limits<T>(clamp);
      static_assert(sizeof(limits) <= sizeof(limits_));
      std::memcpy(limits_, &limits, sizeof(limits));
    });
  }

  Counters run(std::span<const std::byte> in, std::span<std::byte> out) const noexcept override {
    const size_t bytes = element_size(type_);
    const size_t count = std::min({count_, in.size() / bytes, out.size() / bytes});
    run_clamp(in.data(), out.data(), count, type_, limits_);
    return {};
  }
  bool in_place_possible() const noexcept override { return true; }
  size_t period() const noexcept override { return 1; }

 private:
  ElementType type_;
  size_t count_;
  alignas(8) std::byte limits_[sizeof(Limits<double>)] = {};
};

}  // namespace

Result<Operation> parse_clamp(std::string_view option) {
  OptionReader reader("clamp", option);
  const auto low = take_limit(reader);
  if (!low) return low.error();
  if (!reader.take(":")) return reader.syntax_error("':' and the highest value", kClampExample);
  const size_t begin = reader.position();
  const auto high = take_limit(reader);
  if (!high) return high.error();
  if (!reader.at_end()) return reader.syntax_error("the end", kClampExample);
  if (*low <= *high) return Operation{Clamp{*low, *high}, {}};
  reader.go_to(begin);
  return reader.value_error("the lower limit of the clamp is above the upper limit",
                            "the lower limit first",
                            "option=" + std::string(option.substr(begin)) + ":" +
                                std::string(option.substr(0, begin - 1)));
}

TemplateSpec get_output(const Clamp&, const TemplateSpec& in) {
  return in;
}

std::optional<TemplateSpec> find_input(const Clamp&, const TemplateSpec& out) {
  return out;
}

std::shared_ptr<const Kernel> make_kernel(const Clamp& clamp, const TensorSpec& in, bool) {
  return std::make_shared<ClampKernel>(clamp, in);
}

}  // namespace weir::transform
