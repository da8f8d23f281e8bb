/* Umbrella header: functions for caps, descriptions, configuration and accelerators that
 * sub-plugins and programs share with the library.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_INTERNAL_H
#define NNSTREAMER_INTERNAL_H
#include "nnstreamer_plugin_api.h"
#include "nnstreamer_plugin_api_converter.h"
#include "nnstreamer_plugin_api_decoder.h"
#include "nnstreamer_plugin_api_filter.h"
#include "nnstreamer_plugin_api_util.h"
#include "nnstreamer_util.h"
#include "nnstreamer_version.h"
#include "tensor_typedef.h"

#endif /* NNSTREAMER_INTERNAL_H */
