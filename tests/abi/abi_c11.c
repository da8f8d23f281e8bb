/* Checks that the C headers compile as C11, alone, and that the frozen structs have their sizes and
 * offsets on LP64.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include "weir/abi.h"
#include "weir/custom_condition.h"
#include "weir/custom_converter.h"
#include "weir/custom_filter.h"
#include "weir/error.h"
#include "weir/model.h"
#include "weir/pipeline.h"
#include "weir/results.h"

#define HAS(type, member, offset) \
  _Static_assert(offsetof(type, member) == (offset), #type "." #member)

_Static_assert(sizeof(weir_tensor_info) == 192, "weir_tensor_info is frozen");
_Static_assert(sizeof(weir_tensor) == 424, "weir_tensor is frozen");
_Static_assert(sizeof(weir_object) == 112, "weir_object is frozen");
_Static_assert(sizeof(weir_option) == 16, "weir_option is frozen");
_Static_assert(sizeof(weir_source_map) == 80, "weir_source_map is frozen");
HAS(weir_tensor_info, type, 0);
HAS(weir_tensor_info, shape, 8);
HAS(weir_tensor_info, name, 136);
HAS(weir_tensor_info, scale, 144);
HAS(weir_tensor_info, layout, 152);
HAS(weir_tensor_info, reserved, 160);
HAS(weir_tensor, data, 0);
HAS(weir_tensor, bytes, 8);
HAS(weir_tensor, stride, 32);
HAS(weir_tensor, memory_kind, 160);
HAS(weir_tensor, release, 184);
HAS(weir_tensor, info, 200);
HAS(weir_tensor, reserved, 392);
HAS(weir_source_map, source_width, 48);
HAS(weir_source_map, row, 72);
HAS(weir_object, class_id, 24);
HAS(weir_object, track_id, 32);
HAS(weir_object, label, 48);
HAS(weir_object, reserved, 80);

/* Tables have the same beginning, so that a host can reject a newer one before it reads further. */
#define BEGINS(type)         \
  HAS(type, struct_size, 0); \
  HAS(type, abi_major, 4);   \
  HAS(type, abi_minor, 6)
BEGINS(weir_host);
BEGINS(weir_engine);
BEGINS(weir_decoder_type);
BEGINS(weir_converter_type);
BEGINS(weir_module);

/* Members are only appended: these keep their offsets. */
HAS(weir_stream_model, inputs, 16);
HAS(weir_stream_model, path, 32);
HAS(weir_decoder_model, set_model, 8);
HAS(weir_result_columns, length, 4);
HAS(weir_result_columns, points, 32);
HAS(weir_frame, tensors, 8);
HAS(weir_frame, deadline, 32);
HAS(weir_frame, flags, 56);
HAS(weir_frame, maps, 72);
HAS(weir_frame, expires, 80);
HAS(weir_open, host_ctx, 64);
HAS(weir_model_info, metadata_json, 72);
HAS(weir_sink_calls, share_input, 24);
HAS(weir_model_options, struct_size, 0);
HAS(weir_model_options, paths, 8);
HAS(weir_model_options, options, 32);
HAS(weir_model_options, timeout_ns, 48);
HAS(weir_host, fail, 8);
HAS(weir_host, extension, 56);
HAS(weir_engine, name, 8);
HAS(weir_engine, flags, 48);
HAS(weir_engine, probe, 56);
HAS(weir_engine, invoke, 112);
HAS(weir_engine, extension, 144);
HAS(weir_decoder_type, open, 32);
HAS(weir_decoder_type, decode, 56);
HAS(weir_decoder_type, extension, 80);
HAS(weir_converter_type, convert, 64);
HAS(weir_module, engines, 8);
HAS(weir_module, extension, 40);

int main(void) {
  return WEIR_ABI_MAJOR == 1 && WEIR_OK == 0 ? 0 : 1;
}
