// Checks that each public header compiles as C++20 with only the public include path, and that the
// C structs match C's.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "weir/abi.h"
#include "weir/c_error.hpp"
#include "weir/codes.h"
#include "weir/converter.hpp"
#include "weir/custom_condition.hpp"
#include "weir/custom_converter.h"
#include "weir/custom_filter.hpp"
#include "weir/decoder.hpp"
#include "weir/engine.hpp"
#include "weir/engine_tools.hpp"
#include "weir/error.h"
#include "weir/join.hpp"
#include "weir/label_file.hpp"
#include "weir/model.h"
#include "weir/module.hpp"
#include "weir/pipeline.h"
#include "weir/result.hpp"
#include "weir/results.h"
#include "weir/results.hpp"
#include "weir/source_map.hpp"
#include "weir/tensor_info.hpp"

#include <type_traits>

static_assert(std::is_standard_layout_v<weir_tensor> && std::is_trivially_copyable_v<weir_tensor>);
static_assert(std::is_standard_layout_v<weir_engine> && std::is_trivially_copyable_v<weir_engine>);
static_assert(sizeof(weir_tensor_info) == 192 && sizeof(weir_tensor) == 424);
static_assert(sizeof(weir_object) == 112);
static_assert(weir::type_of<float> == WEIR_FLOAT32 && weir::type_of<weir::Float16> == WEIR_FLOAT16);
static_assert(!weir::TensorElement<bool> && !weir::TensorElement<const char*>);
static_assert(weir::element_bytes(WEIR_FLOAT16) == 2 && weir::element_bytes(WEIR_TYPE_END) == 0);

int main() {
  weir_tensor_info picture{};
  picture.type = WEIR_UINT8;
  picture.rank = 3;
  picture.shape[0] = 224;
  picture.shape[1] = -1;
  picture.shape[2] = 3;
  const bool good = weir::describe(picture) == "uint8 3:?:224" &&
                    weir::dimension(picture, 2) == 224 && weir::dimension(picture, 3) == 1;
  return good ? 0 : 1;
}
