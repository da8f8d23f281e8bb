 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* Small things that every part uses: exported names, printf checks, the log.
 *
 * The log goes where Weir's own goes: the debug category of GStreamer named `weir`
 * (GST_DEBUG=weir:5 shows all four levels). */
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

/* For parameters that a callback does not need. */
#define NNS_UNUSED(name) (void)(name)
#ifndef UNUSED
#define UNUSED(name) NNS_UNUSED(name)
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Debug, information, warning, error; `format` as printf's. Thread-safe. Signatures derived. */
NNS_EXPORT void nns_logd(const char* format, ...) NNS_PRINTF(1, 2);
NNS_EXPORT void nns_logi(const char* format, ...) NNS_PRINTF(1, 2);
NNS_EXPORT void nns_logw(const char* format, ...) NNS_PRINTF(1, 2);
NNS_EXPORT void nns_loge(const char* format, ...) NNS_PRINTF(1, 2);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_UTIL_H */
