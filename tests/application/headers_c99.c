/* Checks that the public headers need only C99 and no previous include, and the numbers on which
 * streams and programs depend.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include "nnstreamer-single.h"
#include "nnstreamer.h"

#define SAME(name, a, b) typedef char name[(a) == (b) ? 1 : -1]
SAME(first_type, ML_TENSOR_TYPE_INT32, 0);
SAME(last_type, ML_TENSOR_TYPE_FLOAT16, 10);
SAME(no_type, ML_TENSOR_TYPE_UNKNOWN, 11);
SAME(good, ML_ERROR_NONE, 0);
SAME(rank, sizeof(ml_tensor_dimension), 16 * sizeof(uint32_t));
SAME(cpu, ML_NNFW_HW_CPU, 0x1000);

int main(void) {
  return ML_ERROR_INVALID_PARAMETER < 0 && ML_ERROR_STREAMS_PIPE < 0 && ML_ERROR_UNKNOWN < 0 ? 0
                                                                                             : 1;
}
