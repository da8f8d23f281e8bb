/* Parsing, printing and comparing of tensor types, dimensions and descriptions. Needs GLib.
 *
 * The published interface names these functions or their prefix; arguments and results are derived.
 * The caller frees strings that are not const with g_free(). Structs must not be NULL unless
 * documented; for NULL functions return FALSE, 0, NULL or _NNS_END and log a line. Thread-safe for
 * different objects.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_PLUGIN_API_UTIL_H
#define NNSTREAMER_PLUGIN_API_UTIL_H
#include <glib.h>

#include "nnstreamer_util.h"
#include "tensor_typedef.h"

/* A text to print, also for NULL; a copy of `n` bytes. */
#define _STR_NULL(text) ((text) ? (text) : "(NULL)")
#define _g_memdup g_memdup2

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Types and dimensions ---- */

/* Parses "uint8" etc., ignoring case and surrounding blanks; _NNS_END for other text. */
NNS_EXPORT tensor_type gst_tensor_get_type(const gchar* text);
/* The static name, or NULL for an invalid type. */
NNS_EXPORT const gchar* gst_tensor_get_type_string(tensor_type type);
/* Bytes of one element; 0 for an invalid type. */
NNS_EXPORT gsize gst_tensor_get_element_size(tensor_type type);
/* Parses "static", "flexible" or "sparse", ignoring case; else _NNS_TENSOR_FORMAT_END. */
NNS_EXPORT tensor_format gst_tensor_get_format(const gchar* text);
/* The static name, or NULL for an invalid format. */
NNS_EXPORT const gchar* gst_tensor_get_format_string(tensor_format format);
/* Parses "3:224:224", innermost first, and writes all of `dim`. Letters after a number are ignored:
 * "5U" is 5. Returns the rank, 0 on failure. */
NNS_EXPORT guint gst_tensor_parse_dimension(const gchar* text, tensor_dim dim);
/* Joins the leading entries that are not 0 with ":"; "" if the first is 0. */
NNS_EXPORT gchar* gst_tensor_get_dimension_string(const tensor_dim dim);
/* Prints the first `rank` entries: cuts longer dimensions and, if `padding` is TRUE, pads shorter
 * ones with ":1". Prints all for a rank of 0 or above 16. */
NNS_EXPORT gchar* gst_tensor_get_rank_dimension_string(const tensor_dim dim,
                                                       const unsigned int rank, gboolean padding);
/* The number of entries in use. */
NNS_EXPORT guint gst_tensor_dimension_get_rank(const tensor_dim dim);
/* The rank without trailing 1s, at least 1; 0 for an invalid dimension. */
NNS_EXPORT guint gst_tensor_dimension_get_min_rank(const tensor_dim dim);
/* TRUE for at least one entry and only zeros after the first 0. */
NNS_EXPORT gboolean gst_tensor_dimension_is_valid(const tensor_dim dim);
/* TRUE if both are valid and equal; missing entries count as 1. */
NNS_EXPORT gboolean gst_tensor_dimension_is_equal(const tensor_dim a, const tensor_dim b);
/* The same for two texts, which may be lists ("3:4,5" or "3:4.5:1") of the same length. FALSE if
 * one does not parse. */
NNS_EXPORT gboolean gst_tensor_dimension_string_is_equal(const gchar* a, const gchar* b);
/* Product of the leading entries; 0 if the first is 0 or the product exceeds 64 bits. */
NNS_EXPORT guint64 gst_tensor_get_element_count(const tensor_dim dim);

/* ---- One tensor ---- */

/* Sets no name, _NNS_END and no dimension. Does not free previous content. */
NNS_EXPORT void gst_tensor_info_init(GstTensorInfo* info);
/* Frees the name and resets the info. */
NNS_EXPORT void gst_tensor_info_free(GstTensorInfo* info);
NNS_EXPORT gboolean gst_tensor_info_validate(const GstTensorInfo* info);
/* Bytes of a dense tensor; 0 if it is invalid or the size overflows. */
NNS_EXPORT gsize gst_tensor_info_get_size(const GstTensorInfo* info);
NNS_EXPORT guint gst_tensor_info_get_rank(const GstTensorInfo* info);
/* TRUE if both are valid with the same type and equal dimensions. Names are ignored. */
NNS_EXPORT gboolean gst_tensor_info_is_equal(const GstTensorInfo* a, const GstTensorInfo* b);
/* Overwrites `to`; copies the name. */
NNS_EXPORT void gst_tensor_info_copy(GstTensorInfo* to, const GstTensorInfo* from);
/* The same with at most the first `n` entries of the dimension; the others become 0. */
NNS_EXPORT void gst_tensor_info_copy_n(GstTensorInfo* to, const GstTensorInfo* from, const guint n);
/* Name, type and dimension for display, such as "'out' uint8 (3:224:224)". */
NNS_EXPORT gchar* gst_tensor_info_to_string(const GstTensorInfo* info);

/* ---- The tensors of a frame ---- */

/* Sets no tensors, static. Does not free previous content. */
NNS_EXPORT void gst_tensors_info_init(GstTensorsInfo* info);
/* Frees names and `extra` and resets the info. */
NNS_EXPORT void gst_tensors_info_free(GstTensorsInfo* info);
/* Tensor `index`, including those in `extra`, which is allocated on first use. NULL for 256 and
 * above. Borrowed. */
NNS_EXPORT GstTensorInfo* gst_tensors_info_get_nth_info(GstTensorsInfo* info, guint index);
/* Static: TRUE for 1 to 256 tensors, each valid. Flexible and sparse: always TRUE. */
NNS_EXPORT gboolean gst_tensors_info_validate(const GstTensorsInfo* info);
/* Bytes of tensor `index`, or of all tensors for -1. */
NNS_EXPORT gsize gst_tensors_info_get_size(const GstTensorsInfo* info, gint index);
NNS_EXPORT gboolean gst_tensors_info_is_equal(const GstTensorsInfo* a, const GstTensorsInfo* b);
/* Overwrites `to` with a deep copy. */
NNS_EXPORT void gst_tensors_info_copy(GstTensorsInfo* to, const GstTensorsInfo* from);
/* Parse lists with "," or "." between tensors (names: "," only). Return the number of tensors read,
 * at most 256; num_tensors is not changed. */
NNS_EXPORT guint gst_tensors_info_parse_dimensions_string(GstTensorsInfo* info, const gchar* text);
NNS_EXPORT guint gst_tensors_info_parse_types_string(GstTensorsInfo* info, const gchar* text);
NNS_EXPORT guint gst_tensors_info_parse_names_string(GstTensorsInfo* info, const gchar* text);
/* Print the same lists for num_tensors tensors, with ",". NULL without tensors. */
NNS_EXPORT gchar* gst_tensors_info_get_dimensions_string(const GstTensorsInfo* info);
/* The dimensions, each in the form of gst_tensor_get_rank_dimension_string(). */
NNS_EXPORT gchar* gst_tensors_info_get_rank_dimensions_string(const GstTensorsInfo* info,
                                                              const unsigned int rank,
                                                              gboolean padding);
NNS_EXPORT gchar* gst_tensors_info_get_types_string(const GstTensorsInfo* info);
NNS_EXPORT gchar* gst_tensors_info_get_names_string(const GstTensorsInfo* info);
/* Format, number and each tensor for display. */
NNS_EXPORT gchar* gst_tensors_info_to_string(const GstTensorsInfo* info);
/* Both side by side, one line per tensor, which ends in "Not equal" where the texts differ. */
NNS_EXPORT gchar* gst_tensors_info_compare_to_string(const GstTensorsInfo* a,
                                                     const GstTensorsInfo* b);

/* ---- A stream ---- */

/* Sets no tensors, static, no valid frame rate. */
NNS_EXPORT void gst_tensors_config_init(GstTensorsConfig* config);
NNS_EXPORT void gst_tensors_config_free(GstTensorsConfig* config);
/* TRUE for valid tensors, rate_n of 0 or more and rate_d above 0. */
NNS_EXPORT gboolean gst_tensors_config_validate(const GstTensorsConfig* config);
/* TRUE if both are valid with equal tensors, equal rates as fractions and equal formats. */
NNS_EXPORT gboolean gst_tensors_config_is_equal(const GstTensorsConfig* a,
                                                const GstTensorsConfig* b);
NNS_EXPORT void gst_tensors_config_copy(GstTensorsConfig* to, const GstTensorsConfig* from);
/* The tensors and the frame rate for display. */
NNS_EXPORT gchar* gst_tensors_config_to_string(const GstTensorsConfig* config);

/* TRUE for a stream of this format; `config` is a pointer. */
#define gst_tensors_config_is_static(config) ((config)->info.format == _NNS_TENSOR_FORMAT_STATIC)
#define gst_tensors_config_is_flexible(config) \
  ((config)->info.format == _NNS_TENSOR_FORMAT_FLEXIBLE)
#define gst_tensors_config_is_sparse(config) ((config)->info.format == _NNS_TENSOR_FORMAT_SPARSE)

/* ---- Lists, configuration ---- */

/* The index of `key`, ignoring case, in a NULL-terminated list; -1 if it is missing. */
NNS_EXPORT gint find_key_strv(const gchar** strv, const gchar* key);
/* A value of nnstreamer.ini, or of the environment variable NNSTREAMER_GROUP_KEY if the file allows
 * it; NULL if there is none. */
NNS_EXPORT gchar* nnsconf_get_custom_value_string(const gchar* group, const gchar* key);
/* The value as a boolean: 1, t, y, on; 0, f, n, of. `def` for other values. */
NNS_EXPORT gboolean nnsconf_get_custom_value_bool(const gchar* group, const gchar* key,
                                                  gboolean def);

/* ---- The interface's release ---- */

/* "NNStreamer 2.7.0"; free it with g_free(). */
NNS_EXPORT gchar* nnstreamer_version_string(void);
/* The parts of the version; pass NULL for a part that you do not need. */
NNS_EXPORT void nnstreamer_version_fetch(guint* major, guint* minor, guint* micro);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_PLUGIN_API_UTIL_H */
