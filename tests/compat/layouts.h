/* The offsets of all members, derived by hand from the published layouts (LP64): pointers and sizes
 * have 8 bytes, the others 4, each at a multiple of its size. Included by a C and a C++ file, which
 * define CHECK.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_TESTS_COMPAT_LAYOUTS_H
#define WEIR_TESTS_COMPAT_LAYOUTS_H
#include <stddef.h>

#include "nnstreamer_plugin_api_converter.h"
#include "nnstreamer_plugin_api_decoder.h"
#include "nnstreamer_plugin_api_filter.h"
#include "nnstreamer_plugin_api_trainer.h"
#include "tensor_filter_custom.h"
#include "tensor_typedef.h"

#define AT(type, member, offset) CHECK(offsetof(type, member) == (offset), #type "." #member)
#define SIZE(type, bytes) CHECK(sizeof(type) == (bytes), "size of " #type)
#define IS(name, number) CHECK((long long)(name) == (number), #name)

IS(NNS_TENSOR_RANK_LIMIT, 16);
IS(NNS_TENSOR_SIZE_LIMIT, 256);
IS(NNS_TENSOR_MEMORY_MAX, 16);
IS(NNS_TENSOR_SIZE_EXTRA_LIMIT, 240);

IS(_NNS_INT32, 0);
IS(_NNS_UINT32, 1);
IS(_NNS_INT16, 2);
IS(_NNS_UINT16, 3);
IS(_NNS_INT8, 4);
IS(_NNS_UINT8, 5);
IS(_NNS_FLOAT64, 6);
IS(_NNS_FLOAT32, 7);
IS(_NNS_INT64, 8);
IS(_NNS_UINT64, 9);
IS(_NNS_FLOAT16, 10);
IS(_NNS_END, 11);
IS(_NNS_TENSOR_FORMAT_STATIC, 0);
IS(_NNS_TENSOR_FORMAT_FLEXIBLE, 1);
IS(_NNS_TENSOR_FORMAT_SPARSE, 2);
IS(_NNS_TENSOR_FORMAT_END, 3);
IS(_NNS_MEDIA_INVALID, -1);
IS(_NNS_VIDEO, 0);
IS(_NNS_AUDIO, 1);
IS(_NNS_TEXT, 2);
IS(_NNS_OCTET, 3);
IS(_NNS_TENSOR, 4);
IS(_NNS_MEDIA_ANY, 0x1000);
IS(_NNS_LAYOUT_ANY, 0);
IS(_NNS_LAYOUT_NHWC, 1);
IS(_NNS_LAYOUT_NCHW, 2);
IS(_NNS_LAYOUT_NONE, 3);
IS(ACCL_NONE, 0);
IS(ACCL_AUTO, 1);
IS(ACCL_DEFAULT, 2);
IS(ACCL_CPU, 0x1000);
IS(ACCL_CPU_SIMD, 0x1100);
IS(ACCL_CPU_NEON, 0x1100);
IS(ACCL_GPU, 0x2000);
IS(ACCL_NPU, 0x4000);
IS(ACCL_NPU_MOVIDIUS, 0x4001);
IS(ACCL_NPU_EDGETPU, 0x4002);
IS(ACCL_NPU_VIVANTE, 0x4003);
IS(ACCL_NPU_SRCN, 0x4004);
IS(ACCL_NPU_SLSI, 0x4005);
IS(ACCL_NPU_SR, 0x4100);
IS(GET_IN_OUT_INFO, 0);
IS(SET_INPUT_INFO, 1);
IS(DESTROY_NOTIFY, 0);
IS(RELOAD_MODEL, 1);
IS(CUSTOM_PROP, 2);
IS(SET_INPUT_PROP, 3);
IS(SET_OUTPUT_PROP, 4);
IS(SET_ACCELERATOR, 5);
IS(CHECK_HW_AVAILABILITY, 6);
IS(SUSPEND, 7);
IS(RESUME, 8);
IS(TRAINER_EVENT_EPOCH_COMPLETION, 0);
IS(TRAINER_EVENT_TRAINING_COMPLETION, 1);
IS(TRAINER_EVENT_UNKNOWN, 2);
CHECK(GST_TENSOR_FILTER_FRAMEWORK_V0 >> 16 == UINT64_C(0xDEAFDEAD0000), "version 0");
CHECK(GST_TENSOR_FILTER_FRAMEWORK_V1 >> 16 == UINT64_C(0xDEAFDEAD0001), "version 1");
CHECK(checkGstTensorFilterFrameworkVersion(GST_TENSOR_FILTER_FRAMEWORK_V0 | 7, 0), "version 0");
CHECK(checkGstTensorFilterFrameworkVersion(GST_TENSOR_FILTER_FRAMEWORK_V1, 1), "version 1");
CHECK(!checkGstTensorFilterFrameworkVersion(GST_TENSOR_FILTER_FRAMEWORK_V1, 0), "version 1");
CHECK(!checkGstTensorFilterFrameworkVersion(UINT64_C(1) << 16, 1), "no version");
CHECK(GST_TENSOR_TRAINER_FRAMEWORK_V1 == UINT64_C(0xDEAFDEAD00010000), "trainer version");

SIZE(tensor_type, 4);
SIZE(tensor_format, 4);
SIZE(media_type, 4);
SIZE(tensor_layout, 4);
SIZE(accl_hw, 4);
SIZE(tensor_dim, 64);
AT(GstTensorInfo, name, 0);
AT(GstTensorInfo, type, 8);
AT(GstTensorInfo, dimension, 12);
SIZE(GstTensorInfo, 80);
AT(GstTensorsInfo, num_tensors, 0);
AT(GstTensorsInfo, info, 8);
AT(GstTensorsInfo, extra, 1288);
AT(GstTensorsInfo, format, 1296);
SIZE(GstTensorsInfo, 1304);
AT(GstTensorsConfig, info, 0);
AT(GstTensorsConfig, rate_n, 1304);
AT(GstTensorsConfig, rate_d, 1308);
SIZE(GstTensorsConfig, 1312);
AT(GstTensorMemory, data, 0);
AT(GstTensorMemory, size, 8);
SIZE(GstTensorMemory, 16);
AT(GstTensorMetaInfo, magic, 0);
AT(GstTensorMetaInfo, version, 4);
AT(GstTensorMetaInfo, type, 8);
AT(GstTensorMetaInfo, dimension, 12);
AT(GstTensorMetaInfo, format, 76);
AT(GstTensorMetaInfo, media_type, 80);
AT(GstTensorMetaInfo, sparse_info.nnz, 84);
SIZE(GstTensorMetaInfo, 88);
SIZE(tensor_element, 8);

AT(GstTensorFilterProperties, fwname, 0);
AT(GstTensorFilterProperties, fw_opened, 8);
AT(GstTensorFilterProperties, model_files, 16);
AT(GstTensorFilterProperties, num_models, 24);
AT(GstTensorFilterProperties, input_configured, 28);
AT(GstTensorFilterProperties, input_meta, 32);
AT(GstTensorFilterProperties, input_layout, 1336);
AT(GstTensorFilterProperties, input_ranks, 2360);
AT(GstTensorFilterProperties, output_configured, 3384);
AT(GstTensorFilterProperties, output_meta, 3392);
AT(GstTensorFilterProperties, output_layout, 4696);
AT(GstTensorFilterProperties, output_ranks, 5720);
AT(GstTensorFilterProperties, custom_properties, 6744);
AT(GstTensorFilterProperties, hw_list, 6752);
AT(GstTensorFilterProperties, num_hw, 6760);
AT(GstTensorFilterProperties, accl_str, 6768);
AT(GstTensorFilterProperties, shared_tensor_filter_key, 6776);
AT(GstTensorFilterProperties, latency, 6784);
AT(GstTensorFilterProperties, throughput, 6788);
AT(GstTensorFilterProperties, invoke_dynamic, 6792);
AT(GstTensorFilterProperties, suspend, 6796);
AT(GstTensorFilterProperties, invoke_async, 6800);
AT(GstTensorFilterProperties, async_callback, 6808);
AT(GstTensorFilterProperties, async_user_data, 6816);
SIZE(GstTensorFilterProperties, 6824);

AT(GstTensorFilterFramework, version, 0);
AT(GstTensorFilterFramework, open, 8);
AT(GstTensorFilterFramework, close, 16);
AT(GstTensorFilterFramework, name, 24);
AT(GstTensorFilterFramework, allow_in_place, 32);
AT(GstTensorFilterFramework, allocate_in_invoke, 36);
AT(GstTensorFilterFramework, run_without_model, 40);
AT(GstTensorFilterFramework, verify_model_path, 44);
AT(GstTensorFilterFramework, statistics, 48);
AT(GstTensorFilterFramework, invoke_NN, 56);
AT(GstTensorFilterFramework, getInputDimension, 64);
AT(GstTensorFilterFramework, getOutputDimension, 72);
AT(GstTensorFilterFramework, setInputDimension, 80);
AT(GstTensorFilterFramework, destroyNotify, 88);
AT(GstTensorFilterFramework, reloadModel, 96);
AT(GstTensorFilterFramework, handleEvent, 104);
AT(GstTensorFilterFramework, checkAvailability, 112);
AT(GstTensorFilterFramework, allocateInInvoke, 120);
AT(GstTensorFilterFramework, invoke, 24);
AT(GstTensorFilterFramework, getFrameworkInfo, 32);
AT(GstTensorFilterFramework, getModelInfo, 40);
AT(GstTensorFilterFramework, eventHandler, 48);
AT(GstTensorFilterFramework, subplugin_data, 56);
SIZE(GstTensorFilterFramework, 128);
AT(GstTensorFilterFrameworkInfo, name, 0);
AT(GstTensorFilterFrameworkInfo, allow_in_place, 8);
AT(GstTensorFilterFrameworkInfo, allocate_in_invoke, 12);
AT(GstTensorFilterFrameworkInfo, run_without_model, 16);
AT(GstTensorFilterFrameworkInfo, verify_model_path, 20);
AT(GstTensorFilterFrameworkInfo, hw_list, 24);
AT(GstTensorFilterFrameworkInfo, num_hw, 32);
AT(GstTensorFilterFrameworkInfo, accl_auto, 36);
AT(GstTensorFilterFrameworkInfo, accl_default, 40);
AT(GstTensorFilterFrameworkInfo, statistics, 48);
SIZE(GstTensorFilterFrameworkInfo, 56);

AT(GstTensorFilterFrameworkStatistics, total_invoke_num, 0);
AT(GstTensorFilterFrameworkStatistics, total_invoke_latency, 8);
AT(GstTensorFilterFrameworkStatistics, total_overhead_latency, 16);
SIZE(GstTensorFilterFrameworkStatistics, 24);
AT(GstTensorFilterFrameworkEventData, data, 0);
AT(GstTensorFilterFrameworkEventData, model_files, 0);
AT(GstTensorFilterFrameworkEventData, num_models, 8);
AT(GstTensorFilterFrameworkEventData, custom_properties, 0);
AT(GstTensorFilterFrameworkEventData, info, 0);
AT(GstTensorFilterFrameworkEventData, layout, 8);
AT(GstTensorFilterFrameworkEventData, hw_list, 0);
AT(GstTensorFilterFrameworkEventData, num_hw, 8);
AT(GstTensorFilterFrameworkEventData, hw, 0);
AT(GstTensorFilterFrameworkEventData, custom, 8);
SIZE(GstTensorFilterFrameworkEventData, 1032);
AT(parse_accl_args, in_accl, 0);
AT(parse_accl_args, sup_accl, 8);
AT(parse_accl_args, auto_accl, 16);
AT(parse_accl_args, def_accl, 24);
SIZE(parse_accl_args, 32);

AT(NNStreamer_custom_class, initfunc, 0);
AT(NNStreamer_custom_class, exitfunc, 8);
AT(NNStreamer_custom_class, getInputDim, 16);
AT(NNStreamer_custom_class, getOutputDim, 24);
AT(NNStreamer_custom_class, setInputDim, 32);
AT(NNStreamer_custom_class, invoke, 40);
AT(NNStreamer_custom_class, allocate_invoke, 48);
AT(NNStreamer_custom_class, destroy_notify, 56);
SIZE(NNStreamer_custom_class, 64);

AT(GstTensorDecoderDef, modename, 0);
AT(GstTensorDecoderDef, init, 8);
AT(GstTensorDecoderDef, exit, 16);
AT(GstTensorDecoderDef, setOption, 24);
AT(GstTensorDecoderDef, getOutCaps, 32);
AT(GstTensorDecoderDef, decode, 40);
AT(GstTensorDecoderDef, getTransformSize, 48);
SIZE(GstTensorDecoderDef, 56);

AT(NNStreamerExternalConverter, name, 0);
AT(NNStreamerExternalConverter, convert, 8);
AT(NNStreamerExternalConverter, get_out_config, 16);
AT(NNStreamerExternalConverter, query_caps, 24);
AT(NNStreamerExternalConverter, open, 32);
AT(NNStreamerExternalConverter, close, 40);
SIZE(NNStreamerExternalConverter, 48);

AT(GstTensorTrainerFramework, version, 0);
AT(GstTensorTrainerFramework, create, 8);
AT(GstTensorTrainerFramework, destroy, 16);
AT(GstTensorTrainerFramework, start, 24);
AT(GstTensorTrainerFramework, stop, 32);
AT(GstTensorTrainerFramework, push_data, 40);
AT(GstTensorTrainerFramework, getStatus, 48);
AT(GstTensorTrainerFramework, getFrameworkInfo, 56);
SIZE(GstTensorTrainerFramework, 64);
AT(GstTensorTrainerFrameworkInfo, name, 0);
AT(GstTensorTrainerProperties, input_meta, 0);
AT(GstTensorTrainerProperties, model_config, 1304);
AT(GstTensorTrainerProperties, model_save_path, 1312);
AT(GstTensorTrainerProperties, model_load_path, 1320);
AT(GstTensorTrainerProperties, num_inputs, 1328);
AT(GstTensorTrainerProperties, num_labels, 1332);
AT(GstTensorTrainerProperties, num_training_samples, 1336);
AT(GstTensorTrainerProperties, num_validation_samples, 1340);
AT(GstTensorTrainerProperties, num_epochs, 1344);
AT(GstTensorTrainerProperties, epoch_count, 1348);
AT(GstTensorTrainerProperties, training_loss, 1352);
AT(GstTensorTrainerProperties, training_accuracy, 1360);
AT(GstTensorTrainerProperties, validation_loss, 1368);
AT(GstTensorTrainerProperties, validation_accuracy, 1376);
SIZE(GstTensorTrainerProperties, 1384);
AT(GstTensorTrainerEventNotifier, version, 0);
AT(GstTensorTrainerEventNotifier, notifier, 8);
SIZE(GstTensorTrainerEventNotifier, 16);

#endif /* WEIR_TESTS_COMPAT_LAYOUTS_H */
