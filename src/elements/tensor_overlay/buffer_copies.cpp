// A pool for as long as the size is the same.
#include "elements/tensor_overlay/buffer_copies.hpp"

#include "gstcpp/frame_errors.hpp"
#include "gstcpp/memory_part.hpp"

namespace weir {

void BufferCopies::clear() {
  if (pool_) gst_buffer_pool_set_active(pool_.get(), FALSE);
  pool_ = {};
}

Status BufferCopies::set_size(size_t bytes) {
  if (pool_ && bytes_ == bytes) return ok();
  clear();
  if (bytes > G_MAXUINT) return gst::memory_ran_out();
  auto pool = gst::Ref<GstBufferPool>::adopt(gst_buffer_pool_new());
  GstStructure* config = gst_buffer_pool_get_config(pool.get());
  gst_buffer_pool_config_set_params(config, nullptr, static_cast<guint>(bytes), 0, 0);
  if (!gst_buffer_pool_set_config(pool.get(), config) ||
      !gst_buffer_pool_set_active(pool.get(), TRUE))
    return gst::memory_ran_out();
  pool_ = std::move(pool);
  bytes_ = bytes;
  return ok();
}

Result<gst::Ref<GstBuffer>> BufferCopies::copy_of(GstBuffer* buffer) {
  const size_t bytes = gst_buffer_get_size(buffer);
  if (auto status = set_size(bytes); !status) return status.error();
  GstBuffer* raw = nullptr;
  if (gst_buffer_pool_acquire_buffer(pool_.get(), &raw, nullptr) != GST_FLOW_OK)
    return gst::memory_ran_out();
  auto out = gst::Ref<GstBuffer>::adopt(raw);
  const gst::Mapped map(raw, GST_MAP_WRITE);
  if (!map) return gst::memory_ran_out();
  if (gst_buffer_extract(buffer, 0, map.bytes().data(), bytes) != bytes)
    return gst::memory_not_mapped();
  constexpr int kAllButMemory =
      GST_BUFFER_COPY_FLAGS | GST_BUFFER_COPY_TIMESTAMPS | GST_BUFFER_COPY_META;
  gst_buffer_copy_into(raw, buffer, static_cast<GstBufferCopyFlags>(kAllButMemory), 0,
                       static_cast<gsize>(-1));
  return out;
}

}  // namespace weir
