 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* Tensors in caps and buffers of GStreamer. Needs GStreamer.
 *
 * The published interface names these functions or their prefix; arguments and results are derived.
 * NULL where a struct or object is needed is answered with FALSE, 0 or NULL and a line in the log.
 */
#ifndef NNSTREAMER_PLUGIN_API_H
#define NNSTREAMER_PLUGIN_API_H
#include <gst/gst.h>

#include "nnstreamer_plugin_api_util.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Caps ---- */

/* Whether these are the caps of a tensor stream: other/tensor or other/tensors. */
NNS_EXPORT gboolean gst_structure_is_tensor_stream(const GstStructure* structure);
/* video, audio, text, octet or tensor; _NNS_MEDIA_INVALID for other caps. */
NNS_EXPORT media_type gst_structure_get_media_type(const GstStructure* structure);
/* Reads one structure of the caps of a tensor stream: what it says is filled in, what it leaves
 * open is not set. FALSE for other streams. `config` is initialised in either case and the caller's
 * to free. */
NNS_EXPORT gboolean gst_tensors_config_from_structure(GstTensorsConfig* config,
                                                      const GstStructure* structure);
/* The same of what the peer of `pad` has or takes; `is_fixed`, which may be NULL, says whether its
 * caps are fixed. FALSE without a peer whose first caps are those of a tensor stream. */
NNS_EXPORT gboolean gst_tensors_config_from_peer(GstPad* pad, GstTensorsConfig* config,
                                                 gboolean* is_fixed);
/* Reads other/tensor and other/tensors. With `validate`, caps that are not fixed or give no valid
 * configuration are FALSE; without, what the caps say is filled in. `config` is initialised in
 * either case, also where `caps` is NULL, and the caller's to free. */
NNS_EXPORT gboolean gst_tensors_config_from_caps(GstTensorsConfig* config, const GstCaps* caps,
                                                 gboolean validate);
/* other/tensors of a configuration; a part that is not known is left out. The caller's. */
NNS_EXPORT GstCaps* gst_tensors_caps_from_config(const GstTensorsConfig* config);
/* other/tensor of a configuration's first tensor. The caller's. */
NNS_EXPORT GstCaps* gst_tensor_caps_from_config(const GstTensorsConfig* config);
/* What source pad `pad` should send: flexible where the peer's first wish or the configuration is,
 * other/tensor for one tensor where the peer takes it, else other/tensors. NULL when the pad's
 * template allows none. The caller's. */
NNS_EXPORT GstCaps* gst_tensor_pad_caps_from_config(GstPad* pad, const GstTensorsConfig* config);

/* Whether caps of both kinds can meet: as gst_caps_can_intersect(), with dimensions equal that
 * differ in trailing 1s only. */
NNS_EXPORT gboolean gst_tensor_caps_can_intersect(GstCaps* caps1, GstCaps* caps2);
/* Writes dimensions of `caps`, which must be writable, as `filter` writes equal ones. */
NNS_EXPORT void gst_tensor_caps_update_dimension(GstCaps* caps, GstCaps* filter);

/* ---- Headers of flexible and sparse tensors ---- */

/* A fresh one: version 1.0, no type, static, media tensor. */
NNS_EXPORT void gst_tensor_meta_info_init(GstTensorMetaInfo* meta);
NNS_EXPORT gboolean gst_tensor_meta_info_validate(const GstTensorMetaInfo* meta);
/* Version of the header; NULL for a part that is not wanted. FALSE where it is none. */
NNS_EXPORT gboolean gst_tensor_meta_info_get_version(const GstTensorMetaInfo* meta, guint* major,
                                                     guint* minor);
/* Bytes in front of the data: 128; 0 when the header is not valid. */
NNS_EXPORT gsize gst_tensor_meta_info_get_header_size(const GstTensorMetaInfo* meta);
/* Bytes of the data; 0 when the header is not valid. */
NNS_EXPORT gsize gst_tensor_meta_info_get_data_size(const GstTensorMetaInfo* meta);
/* Writes all 128 bytes of `header`. FALSE, nothing written, when `meta` is not valid. */
NNS_EXPORT gboolean gst_tensor_meta_info_update_header(const GstTensorMetaInfo* meta,
                                                       gpointer header);
/* Reads the 128 bytes of `header`. FALSE when they are no header. */
NNS_EXPORT gboolean gst_tensor_meta_info_parse_header(GstTensorMetaInfo* meta,
                                                      gconstpointer header);
/* Reads the header at the beginning of a memory. FALSE where it has none. */
NNS_EXPORT gboolean gst_tensor_meta_info_parse_memory(GstTensorMetaInfo* meta, GstMemory* memory);
/* A new memory, the caller's: the header, then the bytes of `memory`, which stays the caller's.
 * NULL when `meta` is not valid. */
NNS_EXPORT GstMemory* gst_tensor_meta_info_append_header(GstTensorMetaInfo* meta,
                                                         GstMemory* memory);
/* Type and dimensions as a description, and back. */
NNS_EXPORT gboolean gst_tensor_meta_info_convert(const GstTensorMetaInfo* meta,
                                                 GstTensorInfo* info);
NNS_EXPORT gboolean gst_tensor_info_convert_to_meta(const GstTensorInfo* info,
                                                    GstTensorMetaInfo* meta);

/* ---- Buffers ---- */

/* From now on memory of GStreamer's default allocator and of tensors starts at a multiple of
 * `alignment` bytes: a power of two, or the mask of one (15 means 16). 0 changes nothing. */
NNS_EXPORT void gst_tensor_alloc_init(gsize alignment);

/* Tensors in a buffer: its memories, and what the 16th packs. */
NNS_EXPORT guint gst_tensor_buffer_get_count(GstBuffer* buffer);
/* Tensor `index` with its header, if any; shared, not copied. NULL when there is none. The
 * caller's. */
NNS_EXPORT GstMemory* gst_tensor_buffer_get_nth_memory(GstBuffer* buffer, guint index);
/* Appends tensor `info`, packing from the 17th on. `memory` is taken over, also when FALSE comes:
 * more than 256 tensors, memory that cannot be mapped. */
NNS_EXPORT gboolean gst_tensor_buffer_append_memory(GstBuffer* buffer, GstMemory* memory,
                                                    const GstTensorInfo* info);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_PLUGIN_API_H */
