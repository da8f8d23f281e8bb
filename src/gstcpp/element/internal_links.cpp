// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/internal_links.hpp"

namespace weir::gst {

std::vector<Ref<GstPad>> linked_inside(GstPad* pad) {
  std::vector<Ref<GstPad>> out;
  const Unique<GstIterator, gst_iterator_free> links(gst_pad_iterate_internal_links(pad));
  if (!links) return out;
  GValue item = G_VALUE_INIT;
  auto result = GST_ITERATOR_OK;
  while (result == GST_ITERATOR_OK || result == GST_ITERATOR_RESYNC) {
    result = gst_iterator_next(links.get(), &item);
    if (result == GST_ITERATOR_OK) {
      out.push_back(Ref<GstPad>::share(static_cast<GstPad*>(g_value_get_object(&item))));
      g_value_reset(&item);
    }
    if (result == GST_ITERATOR_RESYNC) {  // pads were added or removed meanwhile
      out.clear();
      gst_iterator_resync(links.get());
    }
  }
  if (G_IS_VALUE(&item)) g_value_unset(&item);
  return out;
}

bool has_task(GstPad* pad) {
  GST_OBJECT_LOCK(pad);
  const bool has = GST_PAD_TASK(pad) != nullptr;
  GST_OBJECT_UNLOCK(pad);
  return has;
}

}  // namespace weir::gst
