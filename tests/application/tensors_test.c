/* Tests of ml_tensors_info_*, ml_tensors_data_* and the handles that all calls share. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#include "check_test_support.h"

static void an_info_keeps_what_it_is_reported(void) {
  ml_tensors_info_h info = NULL, copy = NULL;
  ml_tensor_dimension picture = {3, 4, 5}, got;
  ml_tensor_type_e type;
  unsigned int count = 9;
  size_t size = 9;
  char* name = NULL;
  bool valid = true;
  OK(ml_tensors_info_create(&info));
  OK(ml_tensors_info_get_count(info, &count));
  CHECK(count == 0);
  OK(ml_tensors_info_validate(info, &valid));
  CHECK(!valid);
  OK(ml_tensors_info_set_count(info, 2));
  OK(ml_tensors_info_validate(info, &valid));
  CHECK(!valid);
  OK(ml_tensors_info_set_tensor_type(info, 0, ML_TENSOR_TYPE_UINT8));
  OK(ml_tensors_info_set_tensor_dimension(info, 0, picture));
  OK(ml_tensors_info_set_tensor_type(info, 1, ML_TENSOR_TYPE_FLOAT64));
  OK(ml_tensors_info_set_tensor_dimension(info, 1, picture));
  OK(ml_tensors_info_set_tensor_name(info, 1, "scores"));
  OK(ml_tensors_info_validate(info, &valid));
  CHECK(valid);
  OK(ml_tensors_info_get_tensor_size(info, 0, &size));
  CHECK(size == 3 * 4 * 5);
  OK(ml_tensors_info_get_tensor_size(info, 1, &size));
  CHECK(size == 3 * 4 * 5 * 8);
  OK(ml_tensors_info_get_tensor_size(info, -1, &size));
  CHECK(size == 3 * 4 * 5 * 9);

  OK(ml_tensors_info_create(&copy));
  OK(ml_tensors_info_clone(copy, info));
  OK(ml_tensors_info_destroy(info));
  OK(ml_tensors_info_get_tensor_dimension(copy, 1, got));
  CHECK(got[0] == 3 && got[1] == 4 && got[2] == 5 && got[3] == 0 && got[15] == 0);
  OK(ml_tensors_info_get_tensor_type(copy, 1, &type));
  CHECK(type == ML_TENSOR_TYPE_FLOAT64);
  OK(ml_tensors_info_get_tensor_name(copy, 1, &name));
  CHECK(name && strcmp(name, "scores") == 0);
  free(name);
  OK(ml_tensors_info_get_tensor_name(copy, 0, &name));
  CHECK(name == NULL);
  OK(ml_tensors_info_set_tensor_name(copy, 1, NULL));
  OK(ml_tensors_info_get_tensor_name(copy, 1, &name));
  CHECK(name == NULL);
  OK(ml_tensors_info_destroy(copy));
}

/* Four tensors of 2^62 bytes are 2^64 together. */
static void tensors_may_be_too_large_together(void) {
  const ml_tensor_dimension dimension = {1U << 31, 1U << 31};
  ml_tensors_info_h info = NULL;
  ml_tensors_data_h data = NULL;
  size_t size = 9;
  unsigned int i;
  OK(ml_tensors_info_create(&info));
  OK(ml_tensors_info_set_count(info, 4));
  for (i = 0; i < 4; ++i) {
    OK(ml_tensors_info_set_tensor_type(info, i, ML_TENSOR_TYPE_UINT8));
    OK(ml_tensors_info_set_tensor_dimension(info, i, dimension));
  }
  OK(ml_tensors_info_get_tensor_size(info, 3, &size));
  CHECK(size == (size_t)1 << 62);
  size = 9;
  CHECK_REFUSED(ml_tensors_info_get_tensor_size(info, -1, &size), ML_ERROR_INVALID_PARAMETER,
                "info describes tensors that are too large together");
  CHECK(size == 9);
  CHECK_REFUSED(ml_tensors_data_create(info, &data), ML_ERROR_INVALID_PARAMETER,
                "info describes tensors that are too large together");
  CHECK(data == NULL);
  OK(ml_tensors_info_destroy(info));
}

/* The order of the types is part of the wire formats: sizes 4 4 2 2 1 1 8 4 8 8 2. */
static void types_have_the_order_of_the_stream(void) {
  static const size_t sizes[] = {4, 4, 2, 2, 1, 1, 8, 4, 8, 8, 2};
  int type;
  for (type = 0; type < 11; ++type) {
    ml_tensors_info_h info = make_info((ml_tensor_type_e)type, 10, 0);
    size_t size = 0;
    OK(ml_tensors_info_get_tensor_size(info, 0, &size));
    CHECK(size == 10 * sizes[type]);
    OK(ml_tensors_info_destroy(info));
  }
}

static void an_info_refuses_what_no_tensor_is(void) {
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_INT8, 7, 0);
  ml_tensor_dimension none = {0}, hole = {3, 0, 2}, huge = {0}, got;
  ml_tensor_type_e type = ML_TENSOR_TYPE_INT64;
  unsigned int i;
  size_t size = 9;
  CHECK_REFUSED(ml_tensors_info_set_count(info, 0), ML_ERROR_INVALID_PARAMETER,
                "count is out of range");
  CHECK_REFUSED(ml_tensors_info_set_count(info, 257), ML_ERROR_INVALID_PARAMETER, "offered: 257");
  CHECK_REFUSED(ml_tensors_info_set_tensor_type(info, 0, ML_TENSOR_TYPE_UNKNOWN),
                ML_ERROR_INVALID_PARAMETER, "type is not a tensor type");
  CHECK_REFUSED(ml_tensors_info_set_tensor_type(info, 0, (ml_tensor_type_e)-1),
                ML_ERROR_INVALID_PARAMETER, "offered: -1");
  CHECK_REFUSED(ml_tensors_info_set_tensor_type(info, 1, ML_TENSOR_TYPE_INT8),
                ML_ERROR_INVALID_PARAMETER, "no tensor has this index\n  offered: 1");
  CHECK_REFUSED(ml_tensors_info_set_tensor_dimension(info, 0, none), ML_ERROR_INVALID_PARAMETER,
                "dimension is not a valid tensor dimension");
  CHECK_REFUSED(ml_tensors_info_set_tensor_dimension(info, 0, hole), ML_ERROR_INVALID_PARAMETER,
                "offered: 3:0:2:0");
  CHECK_REFUSED(ml_tensors_info_set_tensor_dimension(info, 0, NULL), ML_ERROR_INVALID_PARAMETER,
                "dimension is a null pointer");
  OK(ml_tensors_info_get_tensor_dimension(info, 0, got));
  CHECK(got[0] == 7);
  CHECK_REFUSED(ml_tensors_info_get_tensor_size(info, 1, &size), ML_ERROR_INVALID_PARAMETER,
                "needed: an index below the number of tensors: 1");
  CHECK(size == 9);
  CHECK_REFUSED(ml_tensors_info_get_tensor_type(info, 1, &type), ML_ERROR_INVALID_PARAMETER,
                "no tensor has this index");
  CHECK(type == ML_TENSOR_TYPE_INT64);
  OK(ml_tensors_info_get_tensor_size(info, -2, &size));
  CHECK(size == 7);
  for (i = 0; i < 4; ++i) huge[i] = 65536;
  OK(ml_tensors_info_set_tensor_dimension(info, 0, huge));
  CHECK_REFUSED(ml_tensors_info_get_tensor_size(info, 0, &size), ML_ERROR_INVALID_PARAMETER,
                "too large");
  OK(ml_tensors_info_destroy(info));
}

static void data_is_zero_and_takes_copies(void) {
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_FLOAT32, 2, 2);
  ml_tensors_data_h data = NULL;
  const float given[4] = {1, 2, 3, 4};
  const float* values;
  OK(ml_tensors_data_create(info, &data));
  OK(ml_tensors_info_destroy(info));
  values = floats(data, 0, 4);
  CHECK(values && values[0] == 0 && values[3] == 0);
  OK(ml_tensors_data_set_tensor_data(data, 0, given, sizeof given));
  CHECK(values && values[0] == 1 && values[3] == 4);
  OK(ml_tensors_data_set_tensor_data(data, 0, &given[2], sizeof(float)));
  CHECK(values && values[0] == 3 && values[1] == 2);
  CHECK_REFUSED(
      ml_tensors_data_set_tensor_data(data, 0, given, sizeof given + 1), ML_ERROR_INVALID_PARAMETER,
      "data_size is out of range for tensor 0\n  offered: 17 bytes\n  needed: 1 to 16 bytes");
  CHECK_REFUSED(ml_tensors_data_set_tensor_data(data, 0, given, 0), ML_ERROR_INVALID_PARAMETER,
                "offered: 0 bytes");
  CHECK_REFUSED(ml_tensors_data_set_tensor_data(data, 1, given, 4), ML_ERROR_INVALID_PARAMETER,
                "no tensor has this index");
  CHECK_REFUSED(ml_tensors_data_set_tensor_data(data, 0, NULL, 4), ML_ERROR_INVALID_PARAMETER,
                "raw_data is a null pointer");
  OK(ml_tensors_data_destroy(data));
}

static void data_needs_an_info_that_is_complete(void) {
  ml_tensors_info_h info = NULL;
  ml_tensors_data_h data = &info;
  OK(ml_tensors_info_create(&info));
  CHECK_REFUSED(ml_tensors_data_create(info, &data), ML_ERROR_INVALID_PARAMETER,
                "info describes no tensor");
  CHECK(data == (void*)&info);
  OK(ml_tensors_info_set_count(info, 1));
  OK(ml_tensors_info_set_tensor_type(info, 0, ML_TENSOR_TYPE_INT8));
  CHECK_REFUSED(ml_tensors_data_create(info, &data), ML_ERROR_INVALID_PARAMETER,
                "first difference: dimensions\n  fix: ml_tensors_info_set_tensor_dimension");
  OK(ml_tensors_info_destroy(info));
}

/* What a local variable of a program written for four dimensions holds. */
static void garbage(ml_tensor_dimension dimension) {
  int i;
  for (i = 0; i < ML_TENSOR_RANK_LIMIT; ++i) dimension[i] = 0x5a5a5a5a;
}

static void a_plain_info_reads_four_dimensions(void) {
  ml_tensors_info_h info = NULL;
  ml_tensors_data_h data = NULL;
  ml_tensor_dimension dimension;
  size_t size = 0;
  OK(ml_tensors_info_create(&info));
  OK(ml_tensors_info_set_count(info, 1));
  OK(ml_tensors_info_set_tensor_type(info, 0, ML_TENSOR_TYPE_UINT8));
  garbage(dimension);
  dimension[0] = 3, dimension[1] = 224, dimension[2] = 224, dimension[3] = 1;
  OK(ml_tensors_info_set_tensor_dimension(info, 0, dimension));
  garbage(dimension);
  OK(ml_tensors_info_get_tensor_dimension(info, 0, dimension));
  CHECK(dimension[0] == 3 && dimension[3] == 1 && dimension[4] == 0 && dimension[15] == 0);
  OK(ml_tensors_info_get_tensor_size(info, 0, &size));
  CHECK(size == 3 * 224 * 224);
  OK(ml_tensors_data_create(info, &data));
  OK(ml_tensors_data_destroy(data));
  garbage(dimension);
  dimension[0] = 3, dimension[1] = 0;
  CHECK_REFUSED(ml_tensors_info_set_tensor_dimension(info, 0, dimension),
                ML_ERROR_INVALID_PARAMETER, "dimension is not a valid tensor dimension");
  dimension[0] = 0, dimension[1] = 1, dimension[2] = 1, dimension[3] = 1;
  CHECK_REFUSED(ml_tensors_info_set_tensor_dimension(info, 0, dimension),
                ML_ERROR_INVALID_PARAMETER, "offered: 0:1:1:1\n");
  OK(ml_tensors_info_destroy(info));
}

static void an_extended_info_reads_all_dimensions(void) {
  ml_tensors_info_h info = NULL, copy = NULL, plain = NULL;
  ml_tensor_dimension dimension = {2, 3, 4, 5, 6}, got, hole = {1, 1, 1, 1, 0, 2};
  OK(ml_tensors_info_create_extended(&info));
  OK(ml_tensors_info_set_count(info, 1));
  OK(ml_tensors_info_set_tensor_type(info, 0, ML_TENSOR_TYPE_UINT8));
  CHECK_REFUSED(ml_tensors_info_set_tensor_dimension(info, 0, hole), ML_ERROR_INVALID_PARAMETER,
                "offered: 1:1:1:1:0:2");
  OK(ml_tensors_info_set_tensor_dimension(info, 0, dimension));
  OK(ml_tensors_info_get_tensor_dimension(info, 0, got));
  CHECK(got[4] == 6 && got[5] == 0);
  /* A clone is what its source is. */
  OK(ml_tensors_info_create(&copy));
  OK(ml_tensors_info_clone(copy, info));
  OK(ml_tensors_info_set_tensor_dimension(copy, 0, dimension));
  OK(ml_tensors_info_get_tensor_dimension(copy, 0, got));
  CHECK(got[4] == 6);
  plain = make_info(ML_TENSOR_TYPE_INT8, 4, 0);
  OK(ml_tensors_info_clone(copy, plain));
  OK(ml_tensors_info_set_tensor_dimension(copy, 0, dimension));
  OK(ml_tensors_info_get_tensor_dimension(copy, 0, got));
  CHECK(got[3] == 5 && got[4] == 0);
  OK(ml_tensors_info_destroy(info));
  OK(ml_tensors_info_create(&info));
  CHECK_REFUSED(ml_tensors_info_clone(copy, info), ML_ERROR_INVALID_PARAMETER,
                "src describes no tensor");
  CHECK_REFUSED(ml_tensors_info_create_extended(NULL), ML_ERROR_INVALID_PARAMETER,
                "info is a null pointer");
  OK(ml_tensors_info_destroy(plain));
  OK(ml_tensors_info_destroy(copy));
  OK(ml_tensors_info_destroy(info));
}

static void infos_of_the_library_fit_their_tensors(void) {
  ml_tensors_info_h five = NULL, four = make_info(ML_TENSOR_TYPE_INT8, 4, 0), got = NULL;
  ml_tensors_data_h data = NULL;
  ml_tensor_dimension dimension = {2, 3, 4, 5, 6}, read;
  OK(ml_tensors_info_create_extended(&five));
  OK(ml_tensors_info_set_count(five, 1));
  OK(ml_tensors_info_set_tensor_type(five, 0, ML_TENSOR_TYPE_UINT8));
  OK(ml_tensors_info_set_tensor_dimension(five, 0, dimension));
  OK(ml_tensors_data_create(five, &data));
  OK(ml_tensors_data_get_info(data, &got));
  OK(ml_tensors_info_set_tensor_dimension(got, 0, dimension));
  OK(ml_tensors_info_get_tensor_dimension(got, 0, read));
  CHECK(read[4] == 6);
  OK(ml_tensors_info_destroy(got));
  OK(ml_tensors_data_destroy(data));
  OK(ml_tensors_data_create(four, &data));
  OK(ml_tensors_data_get_info(data, &got));
  OK(ml_tensors_info_set_tensor_dimension(got, 0, dimension));
  OK(ml_tensors_info_get_tensor_dimension(got, 0, read));
  CHECK(read[4] == 0);
  CHECK_REFUSED(ml_tensors_data_get_info(data, NULL), ML_ERROR_INVALID_PARAMETER,
                "info is a null pointer");
  CHECK_REFUSED(ml_tensors_data_get_info(four, &got), ML_ERROR_INVALID_PARAMETER,
                "data is a handle of a different type");
  OK(ml_tensors_info_destroy(got));
  OK(ml_tensors_data_destroy(data));
  OK(ml_tensors_info_destroy(five));
  OK(ml_tensors_info_destroy(four));
}

static void a_lower_count_hides_tensors(void) {
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_INT8, 7, 0);
  ml_tensor_type_e type = ML_TENSOR_TYPE_UNKNOWN;
  OK(ml_tensors_info_set_count(info, 3));
  OK(ml_tensors_info_get_tensor_type(info, 2, &type));
  CHECK(type == ML_TENSOR_TYPE_UNKNOWN);
  OK(ml_tensors_info_set_tensor_type(info, 2, ML_TENSOR_TYPE_FLOAT64));
  OK(ml_tensors_info_set_count(info, 1));
  CHECK_REFUSED(ml_tensors_info_get_tensor_type(info, 2, &type), ML_ERROR_INVALID_PARAMETER,
                "an index below the number of tensors: 1");
  OK(ml_tensors_info_set_count(info, 256));
  OK(ml_tensors_info_get_tensor_type(info, 2, &type));
  CHECK(type == ML_TENSOR_TYPE_FLOAT64);
  OK(ml_tensors_info_destroy(info));
}

static void an_incomplete_tensor_has_no_size(void) {
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_INT16, 7, 0);
  size_t size = 9;
  OK(ml_tensors_info_set_count(info, 2));
  OK(ml_tensors_info_get_tensor_size(info, 1, &size));
  CHECK(size == 0);
  OK(ml_tensors_info_get_tensor_size(info, -1, &size));
  CHECK(size == 14);
  OK(ml_tensors_info_destroy(info));
}

static void data_is_cloned(void) {
  ml_tensors_data_h data = two_floats(5), copy = NULL;
  const float* values;
  const float other = 7;
  OK(ml_tensors_data_clone(data, &copy));
  OK(ml_tensors_data_set_tensor_data(data, 0, &other, sizeof other));
  values = floats(copy, 0, 2);
  CHECK(values && values[0] == 5 && values[1] == -5);
  OK(ml_tensors_data_set_tensor_data(copy, 0, &other, sizeof other));
  CHECK(values && values[0] == 7);
  CHECK_REFUSED(ml_tensors_data_clone(NULL, &copy), ML_ERROR_INVALID_PARAMETER,
                "in is a null pointer");
  CHECK_REFUSED(ml_tensors_data_clone(data, NULL), ML_ERROR_INVALID_PARAMETER,
                "out is a null pointer");
  OK(ml_tensors_data_destroy(data));
  values = floats(copy, 0, 2);
  CHECK(values && values[1] == -5);
  OK(ml_tensors_data_destroy(copy));
}

static void errors_are_read_once(void) {
  const char* text;
  CHECK(ml_tensors_info_create(NULL) == ML_ERROR_INVALID_PARAMETER);
  text = ml_error();
  CHECK(text && strstr(text, "info is a null pointer"));
  CHECK(ml_error() == NULL);
  CHECK(ml_tensors_info_destroy(NULL) == ML_ERROR_INVALID_PARAMETER);
  CHECK(ml_error() != NULL);
}

static void codes_have_texts(void) {
  static const int codes[] = {
      ML_ERROR_INVALID_PARAMETER, ML_ERROR_STREAMS_PIPE,  ML_ERROR_TRY_AGAIN,
      ML_ERROR_UNKNOWN,           ML_ERROR_TIMED_OUT,     ML_ERROR_NOT_SUPPORTED,
      ML_ERROR_PERMISSION_DENIED, ML_ERROR_OUT_OF_MEMORY, ML_ERROR_IO_ERROR};
  size_t i;
  unsigned int version[3] = {0, 0, 0};
  char* text;
  for (i = 0; i < sizeof codes / sizeof *codes; ++i) {
    CHECK(ml_strerror(codes[i]) && *ml_strerror(codes[i]));
    CHECK(ml_strerror(codes[i]) == ml_strerror(-codes[i]));
  }
  CHECK(ml_strerror(0) == NULL && ml_strerror(-4711) == NULL);
  ml_api_get_version(&version[0], &version[1], NULL);
  ml_api_get_version(NULL, NULL, &version[2]);
  CHECK(version[0] == 1 && version[1] == 8 && version[2] == 8);
  text = ml_api_get_version_string();
  CHECK(text && strcmp(text, "Machine Learning API 1.8.8") == 0);
  free(text);
}

static void count_it(void* data) {
  ++*(int*)data;
}

static void options_keep_values(void) {
  ml_option_h option = NULL;
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_INT8, 1, 0);
  int first = 0, second = 0, kept = 0;
  void* value = NULL;
  OK(ml_option_create(&option));
  OK(ml_option_set(option, "a", &first, count_it));
  OK(ml_option_set(option, "b", &kept, NULL));
  OK(ml_option_get(option, "a", &value));
  CHECK(value == &first && first == 0);
  OK(ml_option_set(option, "a", &second, count_it));
  CHECK(first == 1);
  CHECK_REFUSED(ml_option_get(option, "c", &value), ML_ERROR_INVALID_PARAMETER,
                "the option has no such key\n  offered: c");
  CHECK(value == &first);
  CHECK_REFUSED(ml_option_set(option, "", &kept, NULL), ML_ERROR_INVALID_PARAMETER, "key is empty");
  CHECK_REFUSED(ml_option_set(option, NULL, &kept, NULL), ML_ERROR_INVALID_PARAMETER,
                "null pointer");
  CHECK_REFUSED(ml_option_set(option, "a", NULL, NULL), ML_ERROR_INVALID_PARAMETER, "null pointer");
  CHECK_REFUSED(ml_option_set(info, "a", &kept, NULL), ML_ERROR_INVALID_PARAMETER,
                "option is a handle of a different type");
  OK(ml_option_destroy(option));
  CHECK(second == 1 && kept == 0);
  CHECK_REFUSED(ml_option_destroy(option), ML_ERROR_INVALID_PARAMETER, "was destroyed");
  OK(ml_tensors_info_destroy(info));
}

static void informations_do_not_exist(void) {
  ml_option_h option = NULL;
  void* value = NULL;
  unsigned int length = 0;
  OK(ml_option_create(&option));
  CHECK_REFUSED(ml_information_get(option, "a", &value), ML_ERROR_INVALID_PARAMETER,
                "information is a handle of a different type");
  CHECK_REFUSED(ml_information_destroy(NULL), ML_ERROR_INVALID_PARAMETER,
                "information is a null pointer");
  CHECK_REFUSED(ml_information_list_length(option, &length), ML_ERROR_INVALID_PARAMETER,
                "list is a handle of a different type");
  CHECK_REFUSED(ml_information_list_get(option, 0, &value), ML_ERROR_INVALID_PARAMETER,
                "list is a handle of a different type");
  CHECK_REFUSED(ml_information_list_destroy(option), ML_ERROR_INVALID_PARAMETER,
                "list is a handle of a different type");
  OK(ml_option_destroy(option));
}

static void handles_differ(void) {
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_INT8, 1, 0), again = NULL;
  ml_tensors_data_h data = NULL;
  unsigned int count;
  int number;
  OK(ml_tensors_data_create(info, &data));
  CHECK_REFUSED(ml_tensors_info_get_count(NULL, &count), ML_ERROR_INVALID_PARAMETER,
                "info is a null pointer");
  CHECK_REFUSED(ml_tensors_info_get_count(data, &count), ML_ERROR_INVALID_PARAMETER,
                "info is a handle of a different type\n  offered: a handle of type tensors data\n"
                "  needed: a handle of type tensors info");
  CHECK_REFUSED(ml_tensors_info_get_count(&number, &count), ML_ERROR_INVALID_PARAMETER,
                "info is not a handle");
  CHECK_REFUSED(ml_tensors_data_destroy(info), ML_ERROR_INVALID_PARAMETER,
                "data is a handle of a different type");
  CHECK_REFUSED(ml_tensors_info_clone(info, data), ML_ERROR_INVALID_PARAMETER, "src is a handle");
  OK(ml_tensors_info_destroy(info));
  CHECK_REFUSED(ml_tensors_info_destroy(info), ML_ERROR_INVALID_PARAMETER,
                "info is a handle that was destroyed or released");
  OK(ml_tensors_info_create(&again));
  CHECK(again != info);
  CHECK_REFUSED(ml_tensors_info_get_count(info, &count), ML_ERROR_INVALID_PARAMETER,
                "was destroyed");
  CHECK(ml_error_number() == 1004);
  CHECK_REFUSED(ml_tensors_info_create(NULL), ML_ERROR_INVALID_PARAMETER, "info is a null pointer");
  CHECK_REFUSED(ml_tensors_data_create(again, NULL), ML_ERROR_INVALID_PARAMETER,
                "data is a null pointer");
  OK(ml_tensors_info_destroy(again));
  OK(ml_tensors_data_destroy(data));
}

int main(void) {
  CHECK(ml_error() == NULL && ml_error_number() == 0);
  an_info_keeps_what_it_is_reported();
  types_have_the_order_of_the_stream();
  an_info_refuses_what_no_tensor_is();
  data_is_zero_and_takes_copies();
  data_needs_an_info_that_is_complete();
  a_plain_info_reads_four_dimensions();
  an_extended_info_reads_all_dimensions();
  infos_of_the_library_fit_their_tensors();
  a_lower_count_hides_tensors();
  an_incomplete_tensor_has_no_size();
  data_is_cloned();
  errors_are_read_once();
  codes_have_texts();
  options_keep_values();
  informations_do_not_exist();
  handles_differ();
  tensors_may_be_too_large_together();
  return result_of_checks();
}
