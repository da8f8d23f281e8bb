// A reference to the buffer, and mappings of its own.
#include "elements/tensor_filter/buffer_owner.hpp"

#include <algorithm>
#include <vector>

#include "gstcpp/ref.hpp"

namespace weir {
namespace {

struct Held {
  gst::Ref<GstBuffer> buffer;
  std::vector<gst::MappedMemory> maps;  // go first

  bool has(const weir_tensor& tensor) const {
    const auto* begin = static_cast<const std::byte*>(tensor.data);
    return std::any_of(maps.begin(), maps.end(), [&](const auto& map) {
      const auto bytes = map.bytes();
      return begin >= bytes.data() && begin + tensor.bytes <= bytes.data() + bytes.size();
    });
  }
};

}  // namespace

std::shared_ptr<const void> BufferOwner::hold() {
  auto held = std::make_shared<Held>();
  held->buffer = gst::Ref<GstBuffer>::share(buffer_);
  for (guint i = 0; i < gst_buffer_n_memory(buffer_); ++i) {
    gst::MappedMemory map(gst_buffer_peek_memory(buffer_, i), GST_MAP_READ);
    if (!map) return nullptr;
    held->maps.push_back(std::move(map));
  }
  const bool all = std::all_of(inputs_.begin(), inputs_.end(),
                               [&](const auto& tensor) { return held->has(tensor); });
  return all ? held : nullptr;
}

}  // namespace weir
