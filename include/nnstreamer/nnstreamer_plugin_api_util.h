 * SPDX-License-Identifier: LGPL-2.1-or-later */
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
/* "static", "flexible" or "sparse", any case; _NNS_TENSOR_FORMAT_END for anything else. */
NNS_EXPORT tensor_format gst_tensor_get_format(const gchar* text);
/* The name, or NULL for what is no format. Static. */
NNS_EXPORT const gchar* gst_tensor_get_format_string(tensor_format format);
/* "3:224:224", innermost first, into `dim`, all of which is written. Of a part with letters after
 * its number the number is read: "5U" is 5. Returns the rank, 0 when nothing can be read. */
NNS_EXPORT guint gst_tensor_parse_dimension(const gchar* text, tensor_dim dim);
/* The leading entries that are not 0, joined with ":"; "" when the first is 0. */
NNS_EXPORT gchar* gst_tensor_get_dimension_string(const tensor_dim dim);
/* The first `rank` of them: a longer dimension is cut, a shorter one is padded with ":1" where
 * `padding` is TRUE. All of them for a rank of 0 or above 16. */
NNS_EXPORT gchar* gst_tensor_get_rank_dimension_string(const tensor_dim dim,
                                                       const unsigned int rank, gboolean padding);
/* How many entries count. */
NNS_EXPORT guint gst_tensor_dimension_get_rank(const tensor_dim dim);
/* The same without trailing 1s: at least 1, 0 for a dimension that is not valid. */
NNS_EXPORT guint gst_tensor_dimension_get_min_rank(const tensor_dim dim);
/* At least one entry, and none behind the first 0. */
NNS_EXPORT gboolean gst_tensor_dimension_is_valid(const tensor_dim dim);
/* Both valid, and equal where a missing entry counts as 1. */
NNS_EXPORT gboolean gst_tensor_dimension_is_equal(const tensor_dim a, const tensor_dim b);
/* The same of two texts, which may be lists ("3:4,5" or "3:4.5:1"): as many dimensions, each equal.
 * FALSE where one cannot be read. */
NNS_EXPORT gboolean gst_tensor_dimension_string_is_equal(const gchar* a, const gchar* b);
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
/* The same with the first `n` entries of the dimension at most; those after them are 0. */
NNS_EXPORT void gst_tensor_info_copy_n(GstTensorInfo* to, const GstTensorInfo* from, const guint n);
/* Name, type and dimension for a reader, such as "out uint8 3:224:224". */
NNS_EXPORT gchar* gst_tensor_info_to_string(const GstTensorInfo* info);

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
/* The dimensions, each as gst_tensor_get_rank_dimension_string() writes it. */
NNS_EXPORT gchar* gst_tensors_info_get_rank_dimensions_string(const GstTensorsInfo* info,
                                                              const unsigned int rank,
                                                              gboolean padding);
NNS_EXPORT gchar* gst_tensors_info_get_types_string(const GstTensorsInfo* info);
NNS_EXPORT gchar* gst_tensors_info_get_names_string(const GstTensorsInfo* info);
/* Format, number and each tensor for a reader. */
NNS_EXPORT gchar* gst_tensors_info_to_string(const GstTensorsInfo* info);
/* Both side by side, one line for each tensor, which says whether they are equal. */
NNS_EXPORT gchar* gst_tensors_info_compare_to_string(const GstTensorsInfo* a,
                                                     const GstTensorsInfo* b);

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
/* The tensors and the frame rate for a reader. */
NNS_EXPORT gchar* gst_tensors_config_to_string(const GstTensorsConfig* config);

/* ---- Lists, configuration ---- */

/* The index of `key`, any case, in a list that ends with NULL; -1 where it is not there. */
NNS_EXPORT gint find_key_strv(const gchar** strv, const gchar* key);
/* A value of nnstreamer.ini, or of the environment variable NNSTREAMER_GROUP_KEY where the file
 * allows it; NULL when there is none. */
NNS_EXPORT gchar* nnsconf_get_custom_value_string(const gchar* group, const gchar* key);
/* The same as a truth: 1, t, y, on; 0, f, n, of. `def` for everything else. */
NNS_EXPORT gboolean nnsconf_get_custom_value_bool(const gchar* group, const gchar* key,
                                                  gboolean def);

/* ---- The interface's release ---- */

/* "NNStreamer 2.7.0"; the caller's. */
NNS_EXPORT gchar* nnstreamer_version_string(void);
/* Its parts; NULL for one that is not wanted. */
NNS_EXPORT void nnstreamer_version_fetch(guint* major, guint* minor, guint* micro);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_PLUGIN_API_UTIL_H */
