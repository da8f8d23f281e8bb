// The table of operators (BuiltinOperator of TensorFlow's schema.fbs): lowered, or only named.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lowering/operators.hpp"

#include <algorithm>
#include <array>

namespace weir::engine {
namespace {

constexpr std::array kOperators{
    KnownOperator{0, "ADD", lower_add},
    KnownOperator{1, "AVERAGE_POOL_2D", lower_average_pool},
    KnownOperator{2, "CONCATENATION", lower_concatenation},
    KnownOperator{3, "CONV_2D", lower_convolution},
    KnownOperator{4, "DEPTHWISE_CONV_2D", lower_depthwise_convolution},
    KnownOperator{5, "DEPTH_TO_SPACE", nullptr},
    KnownOperator{6, "DEQUANTIZE", lower_dequantize},
    KnownOperator{7, "EMBEDDING_LOOKUP", nullptr},
    KnownOperator{8, "FLOOR", nullptr},
    KnownOperator{9, "FULLY_CONNECTED", lower_fully_connected},
    KnownOperator{11, "L2_NORMALIZATION", nullptr},
    KnownOperator{14, "LOGISTIC", lower_logistic},
    KnownOperator{16, "LSTM", nullptr},
    KnownOperator{17, "MAX_POOL_2D", lower_max_pool},
    KnownOperator{18, "MUL", lower_multiply},
    KnownOperator{19, "RELU", nullptr},
    KnownOperator{20, "RELU_N1_TO_1", nullptr},
    KnownOperator{21, "RELU6", nullptr},
    KnownOperator{22, "RESHAPE", lower_reshape},
    KnownOperator{23, "RESIZE_BILINEAR", lower_bilinear},
    KnownOperator{25, "SOFTMAX", lower_softmax},
    KnownOperator{26, "SPACE_TO_DEPTH", nullptr},
    KnownOperator{27, "SVDF", nullptr},
    KnownOperator{28, "TANH", nullptr},
    KnownOperator{34, "PAD", lower_pad},
    KnownOperator{36, "GATHER", lower_gather},
    KnownOperator{39, "TRANSPOSE", nullptr},
    KnownOperator{40, "MEAN", nullptr},
    KnownOperator{41, "SUB", lower_subtract},
    KnownOperator{42, "DIV", lower_divide},
    KnownOperator{43, "SQUEEZE", nullptr},
    KnownOperator{44, "UNIDIRECTIONAL_SEQUENCE_LSTM", nullptr},
    KnownOperator{45, "STRIDED_SLICE", lower_strided_slice},
    KnownOperator{47, "EXP", nullptr},
    KnownOperator{49, "SPLIT", nullptr},
    KnownOperator{53, "CAST", lower_cast},
    KnownOperator{54, "PRELU", nullptr},
    KnownOperator{55, "MAXIMUM", nullptr},
    KnownOperator{56, "ARG_MAX", lower_arg_max},
    KnownOperator{57, "MINIMUM", nullptr},
    KnownOperator{59, "NEG", nullptr},
    KnownOperator{60, "PADV2", nullptr},
    KnownOperator{65, "SLICE", nullptr},
    KnownOperator{67, "TRANSPOSE_CONV", lower_transposed_convolution},
    KnownOperator{70, "EXPAND_DIMS", nullptr},
    KnownOperator{73, "LOG", nullptr},
    KnownOperator{74, "SUM", nullptr},
    KnownOperator{75, "SQRT", lower_square_root},
    KnownOperator{76, "RSQRT", nullptr},
    KnownOperator{77, "SHAPE", nullptr},
    KnownOperator{82, "REDUCE_MAX", nullptr},
    KnownOperator{83, "PACK", lower_pack},
    KnownOperator{88, "UNPACK", lower_unpack},
    KnownOperator{90, "FLOOR_DIV", lower_floor_divide},
    KnownOperator{97, "RESIZE_NEAREST_NEIGHBOR", lower_nearest_neighbour},
    KnownOperator{98, "LEAKY_RELU", nullptr},
    KnownOperator{102, "SPLIT_V", nullptr},
    KnownOperator{107, "GATHER_ND", lower_gather_nd},
    KnownOperator{109, "WHERE", nullptr},
    KnownOperator{114, "QUANTIZE", lower_quantize},
    KnownOperator{117, "HARD_SWISH", nullptr},
    KnownOperator{118, "IF", nullptr},
    KnownOperator{119, "WHILE", nullptr},
    KnownOperator{126, "BATCH_MATMUL", nullptr},
    KnownOperator{131, "RFFT2D", nullptr},
    KnownOperator{135, "COMPLEX_ABS", nullptr},
};

}  // namespace

const KnownOperator* known_operator(int32_t code) {
  const auto* found = std::find_if(kOperators.begin(), kOperators.end(),
                                   [code](const KnownOperator& op) { return op.code == code; });
  return found == kOperators.end() ? nullptr : found;
}

}  // namespace weir::engine
