// Fuzz target: preparations of any kind over planes of any size, offset and stride. What is refused
// must be refused with words; what is not must stay within its memory.
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "core/preprocess/plan.hpp"
#include "core/preprocess/request.hpp"

namespace {

using namespace weir::preprocess;

// Numbers from the input, 0 when it has ended.
class Bytes {
 public:
  Bytes(const uint8_t* data, size_t size) : data_(data), size_(size) {}
  uint32_t next() { return at_ < size_ ? data_[at_++] : 0; }
  uint32_t next16() { return next() | next() << 8; }
  double number() { return (static_cast<double>(next16()) - 32768) / 64; }
  std::string_view rest() const {
    return {reinterpret_cast<const char*>(data_) + at_, size_ - at_};
  }

 private:
  const uint8_t* data_;
  size_t size_, at_ = 0;
};

Preparation preparation_from(Bytes* in) {
  Preparation p;
  p.source.format = picture_formats()[in->next() % picture_formats().size()];
  p.source.width = in->next();
  p.source.height = in->next();
  p.source.matrix = static_cast<ColorMatrix>(in->next() % 3);
  p.source.range = static_cast<Range>(in->next() % 2);
  p.source.cosited_columns = in->next() % 2;
  p.source.cosited_rows = in->next() % 2;
  if (in->next() % 2) p.crop = Rect{in->next(), in->next(), in->next(), in->next()};
  p.width = in->next();
  p.height = in->next();
  p.resize = static_cast<Resize>(in->next() % 3);
  p.fit = static_cast<Fit>(in->next() % 3);
  p.padding = in->next();
  p.order = static_cast<ChannelOrder>(in->next() % 3);
  p.layout = static_cast<Layout>(in->next() % 2);
  p.type = static_cast<weir::ElementType>(in->next() % 11);
  for (uint32_t i = in->next() % 5; i > 0; --i) p.mean.push_back(in->number());
  for (uint32_t i = in->next() % 5; i > 0; --i) p.scale.push_back(in->number());
  if (in->next() % 2)
    p.quantisation = Quantisation{in->number(), static_cast<int32_t>(in->next()) - 128};
  return p;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  Bytes in(data, size);
  const Preparation p = preparation_from(&in);
  Planes planes;
  std::vector<std::vector<std::byte>> memories;
  for (auto& plane : planes) {
    memories.emplace_back(in.next16());
    plane = {memories.back(), in.next16(), static_cast<ptrdiff_t>(in.next16()) - 4096};
  }
  const auto numbers = parse_numbers("mean", in.rest());
  const auto quantisation = parse_quantisation(in.rest());
  const auto plan = Plan::make(p);
  if (!plan) {
    if (plan.error().what.empty()) std::abort();
    return 0;
  }
  std::vector<std::byte> out(*p.tensor().bytes());
  auto workspace = plan->workspace();
  const auto status = plan->run(planes, out, &workspace);
  if (!status && status.error().what.empty()) std::abort();
  return 0;
}
