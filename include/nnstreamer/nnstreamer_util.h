/* Basic macros and logging: exported symbols, printf checks, the log.
 *
 * Messages go to the GStreamer debug category `weir-nnstreamer` (GST_DEBUG=weir-nnstreamer:5 shows
 * all four levels).
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_UTIL_H
#define NNSTREAMER_UTIL_H

#if defined(__GNUC__)
#define NNS_EXPORT __attribute__((visibility("default")))
#define NNS_PRINTF(text, first) __attribute__((format(printf, text, first)))
#define NNS_SENTINEL __attribute__((sentinel))
#else
#define NNS_EXPORT
#define NNS_PRINTF(text, first)
#define NNS_SENTINEL
#endif

/* For unused parameters of callbacks. */
#define NNS_UNUSED(name) (void)(name)
#ifndef UNUSED
#define UNUSED(name) NNS_UNUSED(name)
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Log at debug, info, warning and error level with a printf format. Thread-safe. Signatures
 * derived. */
NNS_EXPORT void nns_logd(const char* format, ...) NNS_PRINTF(1, 2);
NNS_EXPORT void nns_logi(const char* format, ...) NNS_PRINTF(1, 2);
NNS_EXPORT void nns_logw(const char* format, ...) NNS_PRINTF(1, 2);
NNS_EXPORT void nns_loge(const char* format, ...) NNS_PRINTF(1, 2);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_UTIL_H */
