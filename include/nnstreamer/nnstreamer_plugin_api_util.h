/* Types, dimensions and descriptions of tensors: reading, writing, comparing. Needs GLib.
 *
 * The published interface names these functions or their prefix; arguments and results are derived
 * from what they are for. Strings that are not const are the caller's: g_free(). No function takes
 * NULL for a struct unless it says so; a NULL that comes nevertheless is answered with FALSE, 0,
 * NULL or _NNS_END and a line in the log. Thread-safe for different objects. */
#ifndef NNSTREAMER_PLUGIN_API_UTIL_H
#define NNSTREAMER_PLUGIN_API_UTIL_H
#include <glib.h>

#include "nnstreamer_util.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Types and dimensions ---- */

/* "uint8" and the like, any case, blanks around it; _NNS_END for anything else. */
NNS_EXPORT tensor_type gst_tensor_get_type(const gchar* text);
/* The name, or NULL for what is no type. Static. */
NNS_EXPORT const gchar* gst_tensor_get_type_string(tensor_type type);
/* Bytes of one element; 0 for what is no type. */
NNS_EXPORT gsize gst_tensor_get_element_size(tensor_type type);
/* "3:224:224", innermost first, into `dim`, all of which is written. Returns the rank, 0 when
 * nothing can be read. */
NNS_EXPORT guint gst_tensor_parse_dimension(const gchar* text, tensor_dim dim);
/* The leading entries that are not 0, joined with ":"; "" when the first is 0. */
NNS_EXPORT gchar* gst_tensor_get_dimension_string(const tensor_dim dim);
/* How many entries count. */
NNS_EXPORT guint gst_tensor_dimension_get_rank(const tensor_dim dim);
/* At least one entry, and none behind the first 0. */
NNS_EXPORT gboolean gst_tensor_dimension_is_valid(const tensor_dim dim);
/* Both valid, and equal where a missing entry counts as 1. */
NNS_EXPORT gboolean gst_tensor_dimension_is_equal(const tensor_dim a, const tensor_dim b);
/* Product of the leading entries; 0 when the first is 0 or the product passes 64 bits. */
NNS_EXPORT guint64 gst_tensor_get_element_count(const tensor_dim dim);

/* ---- One tensor ---- */

/* No name, _NNS_END, no dimension. What was there is not freed. */
NNS_EXPORT void gst_tensor_info_init(GstTensorInfo* info);
/* Frees the name and makes it an empty one. */
NNS_EXPORT void gst_tensor_info_free(GstTensorInfo* info);
NNS_EXPORT gboolean gst_tensor_info_validate(const GstTensorInfo* info);
/* Bytes of a dense tensor; 0 when it is not valid or does not fit. */
NNS_EXPORT gsize gst_tensor_info_get_size(const GstTensorInfo* info);
NNS_EXPORT guint gst_tensor_info_get_rank(const GstTensorInfo* info);
/* Both valid, of one type, with equal dimensions. Names do not count. */
NNS_EXPORT gboolean gst_tensor_info_is_equal(const GstTensorInfo* a, const GstTensorInfo* b);
/* `to` is written over; its name is a copy. */
NNS_EXPORT void gst_tensor_info_copy(GstTensorInfo* to, const GstTensorInfo* from);

/* ---- The tensors of a frame ---- */

/* No tensors, static. What was there is not freed. */
NNS_EXPORT void gst_tensors_info_init(GstTensorsInfo* info);
/* Frees names and `extra`, and makes it an empty one. */
NNS_EXPORT void gst_tensors_info_free(GstTensorsInfo* info);
/* Tensor `index`, also of those in `extra`, which is made when it is first asked for. NULL from 256
 * on. Borrowed. */
NNS_EXPORT GstTensorInfo* gst_tensors_info_get_nth_info(GstTensorsInfo* info, guint index);
/* Static: 1 to 256 tensors, each valid. Flexible and sparse: always. */
NNS_EXPORT gboolean gst_tensors_info_validate(const GstTensorsInfo* info);
/* Bytes of tensor `index`, or of all of them for -1. */
NNS_EXPORT gsize gst_tensors_info_get_size(const GstTensorsInfo* info, gint index);
NNS_EXPORT gboolean gst_tensors_info_is_equal(const GstTensorsInfo* a, const GstTensorsInfo* b);
/* `to` is written over; nothing is shared. */
NNS_EXPORT void gst_tensors_info_copy(GstTensorsInfo* to, const GstTensorsInfo* from);
/* Lists with "," or "." between tensors (names: "," only). Return the number of tensors that were
 * read, at most 256; num_tensors is not touched. */
NNS_EXPORT guint gst_tensors_info_parse_dimensions_string(GstTensorsInfo* info, const gchar* text);
NNS_EXPORT guint gst_tensors_info_parse_types_string(GstTensorsInfo* info, const gchar* text);
NNS_EXPORT guint gst_tensors_info_parse_names_string(GstTensorsInfo* info, const gchar* text);
/* The same lists of num_tensors tensors, with ",". NULL when there are none. */
NNS_EXPORT gchar* gst_tensors_info_get_dimensions_string(const GstTensorsInfo* info);
NNS_EXPORT gchar* gst_tensors_info_get_types_string(const GstTensorsInfo* info);
NNS_EXPORT gchar* gst_tensors_info_get_names_string(const GstTensorsInfo* info);

/* ---- A stream ---- */

/* No tensors, static, no valid frame rate. */
NNS_EXPORT void gst_tensors_config_init(GstTensorsConfig* config);
NNS_EXPORT void gst_tensors_config_free(GstTensorsConfig* config);
/* Valid tensors, rate_n from 0 on, rate_d above 0. */
NNS_EXPORT gboolean gst_tensors_config_validate(const GstTensorsConfig* config);
/* Both valid, equal tensors, equal rates as fractions, equal formats. */
NNS_EXPORT gboolean gst_tensors_config_is_equal(const GstTensorsConfig* a,
                                                const GstTensorsConfig* b);
NNS_EXPORT void gst_tensors_config_copy(GstTensorsConfig* to, const GstTensorsConfig* from);

/* ---- The interface's release ---- */

/* "2.7.0"; the caller's. */
NNS_EXPORT gchar* nnstreamer_version_string(void);
/* Its parts; NULL for one that is not wanted. */
NNS_EXPORT void nnstreamer_version_fetch(guint* major, guint* minor, guint* micro);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_PLUGIN_API_UTIL_H */
