/* Tensors in GStreamer caps and buffers. Needs GStreamer.
 *
 * The published interface names these functions or their prefix; arguments and results are derived.
 * For a NULL struct or object functions return FALSE, 0 or NULL and log a line.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_PLUGIN_API_H
#define NNSTREAMER_PLUGIN_API_H
#include <gst/gst.h>

#include "nnstreamer_plugin_api_util.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Caps ---- */

/* TRUE for caps of a tensor stream: other/tensor or other/tensors. */
NNS_EXPORT gboolean gst_structure_is_tensor_stream(const GstStructure* structure);
/* video, audio, text, octet or tensor; _NNS_MEDIA_INVALID for other caps. */
NNS_EXPORT media_type gst_structure_get_media_type(const GstStructure* structure);
/* Reads one structure of tensor stream caps; open fields stay unset. FALSE for other streams.
 * Initialises `config` in either case; the caller frees it. */
NNS_EXPORT gboolean gst_tensors_config_from_structure(GstTensorsConfig* config,
                                                      const GstStructure* structure);
/* The same for the current caps, or else the query caps, of the peer of `pad`. `is_fixed` may be
 * NULL; it is set to TRUE if these caps are fixed. FALSE without a peer or if its first caps are
 * not those of a tensor stream. */
NNS_EXPORT gboolean gst_tensors_config_from_peer(GstPad* pad, GstTensorsConfig* config,
                                                 gboolean* is_fixed);
/* Reads other/tensor and other/tensors. With `validate`, returns FALSE for caps that are not fixed
 * or yield no valid configuration; without it, reads what the caps contain. Initialises `config` in
 * either case, even if `caps` is NULL; the caller frees it. */
NNS_EXPORT gboolean gst_tensors_config_from_caps(GstTensorsConfig* config, const GstCaps* caps,
                                                 gboolean validate);
/* Makes other/tensors caps; unknown fields are omitted. The caller owns them. */
NNS_EXPORT GstCaps* gst_tensors_caps_from_config(const GstTensorsConfig* config);
/* Makes other/tensor caps of the first tensor. The caller owns them. */
NNS_EXPORT GstCaps* gst_tensor_caps_from_config(const GstTensorsConfig* config);
/* Chooses caps for the source pad `pad`: flexible if the peer's first choice or the configuration
 * is, other/tensor for one tensor if the peer accepts it, else other/tensors. NULL if the pad
 * template allows none. The caller owns them. */
NNS_EXPORT GstCaps* gst_tensor_pad_caps_from_config(GstPad* pad, const GstTensorsConfig* config);

/* gst_caps_can_intersect() that treats dimensions as equal if they differ in trailing 1s only. */
NNS_EXPORT gboolean gst_tensor_caps_can_intersect(GstCaps* caps1, GstCaps* caps2);
/* Rewrites dimensions of the writable `caps` in the form that `filter` has for equal ones. */
NNS_EXPORT void gst_tensor_caps_update_dimension(GstCaps* caps, GstCaps* filter);

/* ---- Headers of flexible and sparse tensors ---- */

/* Initialises to version 1.0, no type, static, media tensor. */
NNS_EXPORT void gst_tensor_meta_info_init(GstTensorMetaInfo* meta);
NNS_EXPORT gboolean gst_tensor_meta_info_validate(const GstTensorMetaInfo* meta);
/* The version of the header; pass NULL for a part that you do not need. FALSE if invalid. */
NNS_EXPORT gboolean gst_tensor_meta_info_get_version(const GstTensorMetaInfo* meta, guint* major,
                                                     guint* minor);
/* Header size in bytes: 128; 0 for an invalid header. */
NNS_EXPORT gsize gst_tensor_meta_info_get_header_size(const GstTensorMetaInfo* meta);
/* Data size in bytes; 0 for an invalid header. */
NNS_EXPORT gsize gst_tensor_meta_info_get_data_size(const GstTensorMetaInfo* meta);
/* Writes all 128 bytes of `header`. FALSE without writing if `meta` is invalid. */
NNS_EXPORT gboolean gst_tensor_meta_info_update_header(const GstTensorMetaInfo* meta,
                                                       gpointer header);
/* Parses the 128 bytes of `header`. FALSE if they are not a header. */
NNS_EXPORT gboolean gst_tensor_meta_info_parse_header(GstTensorMetaInfo* meta,
                                                      gconstpointer header);
/* Parses the header at the start of a memory. FALSE if it has none. */
NNS_EXPORT gboolean gst_tensor_meta_info_parse_memory(GstTensorMetaInfo* meta, GstMemory* memory);
/* Makes a new memory with the header followed by the bytes of `memory`, which the caller keeps. The
 * caller owns the result. NULL if `meta` is invalid. */
NNS_EXPORT GstMemory* gst_tensor_meta_info_append_header(GstTensorMetaInfo* meta,
                                                         GstMemory* memory);
/* Convert between the header and a description of type and dimensions. */
NNS_EXPORT gboolean gst_tensor_meta_info_convert(const GstTensorMetaInfo* meta,
                                                 GstTensorInfo* info);
NNS_EXPORT gboolean gst_tensor_info_convert_to_meta(const GstTensorInfo* info,
                                                    GstTensorMetaInfo* meta);

/* ---- Buffers ---- */

/* Sets the alignment, in bytes, of memory from GStreamer's default allocator and of tensors: a
 * power of two, or its mask (15 means 16). 0 has no effect. */
NNS_EXPORT void gst_tensor_alloc_init(gsize alignment);

/* Number of tensors in a buffer: its memories, plus those packed in the 16th. */
NNS_EXPORT guint gst_tensor_buffer_get_count(GstBuffer* buffer);
/* Tensor `index` including its header, shared, not copied. NULL if it does not exist. The caller
 * owns the reference. */
NNS_EXPORT GstMemory* gst_tensor_buffer_get_nth_memory(GstBuffer* buffer, guint index);
/* Appends tensor `info`, packing from the 17th on. Takes ownership of `memory` even on failure.
 * FALSE for more than 256 tensors or memory that cannot be mapped. */
NNS_EXPORT gboolean gst_tensor_buffer_append_memory(GstBuffer* buffer, GstMemory* memory,
                                                    const GstTensorInfo* info);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_PLUGIN_API_H */
