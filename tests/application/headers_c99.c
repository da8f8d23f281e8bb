/* Checks that the public headers need only C99 and no previous include, that each of the two brings
 * the common part, and the numbers on which programs depend (docs/compatibility/app-api.md 8.7).
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifdef SINGLE
#include <nnstreamer-single.h>
#else
#include <nnstreamer.h>
#endif

#define SAME(name, a, b) typedef char name[(a) == (b) ? 1 : -1]
SAME(first_type, ML_TENSOR_TYPE_INT32, 0);
SAME(last_type, ML_TENSOR_TYPE_FLOAT16, 10);
SAME(no_type, ML_TENSOR_TYPE_UNKNOWN, 11);
SAME(rank, sizeof(ml_tensor_dimension), 16 * sizeof(uint32_t));
SAME(tensors, ML_TENSOR_SIZE_LIMIT, 256);

SAME(good, ML_ERROR_NONE, 0);
SAME(invalid, ML_ERROR_INVALID_PARAMETER, -22);
SAME(streams_pipe, ML_ERROR_STREAMS_PIPE, -86);
SAME(try_again, ML_ERROR_TRY_AGAIN, -11);
SAME(unknown, ML_ERROR_UNKNOWN, -1073741824);
SAME(timed_out, ML_ERROR_TIMED_OUT, -1073741823);
SAME(not_supported, ML_ERROR_NOT_SUPPORTED, -1073741822);
SAME(denied, ML_ERROR_PERMISSION_DENIED, -13);
SAME(out_of_memory, ML_ERROR_OUT_OF_MEMORY, -12);
SAME(io, ML_ERROR_IO_ERROR, -5);
SAME(package_manager, TIZEN_ERROR_PACKAGE_MANAGER, -0x01150000);
SAME(tizen, TIZEN_ERROR_NOT_SUPPORTED, (int)ML_ERROR_NOT_SUPPORTED);

SAME(tflite, ML_NNFW_TYPE_TENSORFLOW_LITE, 2);
SAME(snpe, ML_NNFW_TYPE_SNPE, 10);
SAME(pytorch, ML_NNFW_TYPE_PYTORCH, 11);
SAME(nntrainer, ML_NNFW_TYPE_NNTR_INF, 12);
SAME(trix, ML_NNFW_TYPE_TRIX_ENGINE, 14);
SAME(tvm, ML_NNFW_TYPE_TVM, 16);
SAME(onnx, ML_NNFW_TYPE_ONNX_RUNTIME, 17);
SAME(hal, ML_NNFW_TYPE_TIZEN_HAL, 22);
SAME(snap, ML_NNFW_TYPE_SNAP, 0x2001);

SAME(automatic, ML_NNFW_HW_AUTO, 1);
SAME(cpu, ML_NNFW_HW_CPU, 0x1000);
SAME(simd, ML_NNFW_HW_CPU_SIMD, 0x1100);
SAME(neon, ML_NNFW_HW_CPU_NEON, 0x1100);
SAME(gpu, ML_NNFW_HW_GPU, 0x2000);
SAME(npu, ML_NNFW_HW_NPU, 0x3000);
SAME(edge_tpu, ML_NNFW_HW_NPU_EDGE_TPU, 0x3002);
SAME(slsi, ML_NNFW_HW_NPU_SLSI, 0x3004);
SAME(sr, ML_NNFW_HW_NPU_SR, 0x13000);

#ifdef SINGLE
static ml_single_h handle;
#else
static ml_pipeline_h handle;
SAME(auto_free, ML_PIPELINE_BUF_POLICY_AUTO_FREE, 0);
SAME(policies, ML_PIPELINE_BUF_POLICY_MAX, 2);
SAME(end, ML_PIPELINE_BUF_SRC_EVENT_EOS, 0x10000);
SAME(ready, ML_PIPELINE_STATE_READY, 2);
SAME(playing, ML_PIPELINE_STATE_PLAYING, 4);
SAME(input_selector, ML_PIPELINE_SWITCH_INPUT_SELECTOR, 1);
#endif

int main(void) {
  void* any = handle; /* handles are void*, and stdlib.h and stdbool.h come with the headers */
  const bool empty = any == NULL;
  free(any);
  return empty ? EXIT_SUCCESS : EXIT_FAILURE;
}
