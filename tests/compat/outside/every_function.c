/* Calls every function of libnnstreamer.so that needs no framework and that programs for NNStreamer
 * link with: its result, and its result for NULL and for invalid values.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <gst/gst.h>
#include <nnstreamer_internal.h>
#include <nnstreamer_plugin_api.h>
#include <nnstreamer_plugin_api_filter.h>
#include <nnstreamer_plugin_api_util.h>
#include <nnstreamer_util.h>
#include <stdio.h>
#include <string.h>

static int failed;
#define CHECK(what)                                              \
  do {                                                           \
    if (!(what)) {                                               \
      fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #what); \
      ++failed;                                                  \
    }                                                            \
  } while (0)

/* Whether the text, which is freed, equals `wanted`; NULL equals NULL. */
static int is(gchar* text, const char* wanted) {
  const int same = g_strcmp0(text, wanted) == 0;
  if (!same) fprintf(stderr, "\"%s\", wanted is \"%s\"\n", text ? text : "NULL", wanted);
  g_free(text);
  return same;
}

static GstStructure* make_structure(const char* text) {
  GstStructure* structure = gst_structure_from_string(text, NULL);
  if (!structure) fprintf(stderr, "no structure: %s\n", text);
  return structure;
}

static media_type parse_media(const char* text) {
  GstStructure* structure = make_structure(text);
  const media_type type = gst_structure_get_media_type(structure);
  gst_structure_free(structure);
  return type;
}

static gboolean is_stream(const char* text) {
  GstStructure* structure = make_structure(text);
  const gboolean result = gst_structure_is_tensor_stream(structure);
  gst_structure_free(structure);
  return result;
}

static void check_lists(void) {
  const gchar* names[] = {"linear", "Stack", "linear", NULL};
  const gchar* none[] = {NULL};
  CHECK(find_key_strv(names, "LINEAR") == 0);
  CHECK(find_key_strv(names, "stack") == 1);
  CHECK(find_key_strv(names, "line") == -1);
  CHECK(find_key_strv(names, "") == -1);
  CHECK(find_key_strv(none, "linear") == -1);
  CHECK(find_key_strv(NULL, "linear") == -1);
  CHECK(find_key_strv(names, NULL) == -1);
}

static void check_media(void) {
  CHECK(is_stream("other/tensor"));
  CHECK(is_stream("other/tensors, format=(string)flexible"));
  CHECK(!is_stream("other/flatbuf-tensor"));
  CHECK(!is_stream("video/x-raw"));
  CHECK(!gst_structure_is_tensor_stream(NULL));
  CHECK(parse_media("video/x-raw, width=(int)4") == _NNS_VIDEO);
  CHECK(parse_media("audio/x-raw") == _NNS_AUDIO);
  CHECK(parse_media("text/x-raw") == _NNS_TEXT);
  CHECK(parse_media("application/octet-stream") == _NNS_OCTET);
  CHECK(parse_media("other/tensor") == _NNS_TENSOR);
  CHECK(parse_media("other/tensors") == _NNS_TENSOR);
  CHECK(parse_media("image/png") == _NNS_MEDIA_INVALID);
  CHECK(parse_media("other/flexbuf") == _NNS_MEDIA_INVALID);
  CHECK(gst_structure_get_media_type(NULL) == _NNS_MEDIA_INVALID);
}

static gboolean make_config(const char* text, GstTensorsConfig* config) {
  GstStructure* structure = make_structure(text);
  const gboolean result = gst_tensors_config_from_structure(config, structure);
  gst_structure_free(structure);
  return result;
}

/* Fills a struct with garbage, as if it had never been initialised before it is freed. */
static void make_garbage(GstTensorsConfig* config) {
  memset(config, 0x5a, sizeof *config);
}

static void check_config(void) {
  GstTensorsConfig config;
  make_garbage(&config);
  CHECK(
      make_config("other/tensors, format=(string)static, num_tensors=(int)2, "
                  "dimensions=(string)\"3:4,5\", types=(string)\"uint8,float32\", "
                  "framerate=(fraction)30/1",
                  &config));
  CHECK(config.info.num_tensors == 2);
  CHECK(config.info.format == _NNS_TENSOR_FORMAT_STATIC);
  CHECK(config.info.info[0].type == _NNS_UINT8 && config.info.info[1].type == _NNS_FLOAT32);
  CHECK(config.info.info[0].dimension[1] == 4 && config.info.info[0].dimension[2] == 0);
  CHECK(config.rate_n == 30 && config.rate_d == 1);
  CHECK(is(gst_tensors_config_to_string(&config),
           "Format = static, Num_Tensors = 2, Tensors = [{ uint8 (3:4) }, { float32 (5) }], "
           "Framerate = 30/1"));
  gst_tensors_config_free(&config);

  CHECK(make_config("other/tensor, dimension=(string)3:4, type=(string)int8", &config));
  CHECK(config.info.num_tensors == 1 && config.info.info[0].type == _NNS_INT8);
  CHECK(config.rate_d == -1);
  gst_tensors_config_free(&config);

  CHECK(make_config("other/tensors, format=(string)flexible, framerate=(fraction)0/1", &config));
  CHECK(config.info.format == _NNS_TENSOR_FORMAT_FLEXIBLE && config.rate_n == 0);
  CHECK(is(gst_tensors_config_to_string(&config), "Format = flexible, Framerate = 0/1"));
  gst_tensors_config_free(&config);

  make_garbage(&config);
  CHECK(!make_config("video/x-raw", &config));
  gst_tensors_config_free(&config);
  make_garbage(&config);
  CHECK(!gst_tensors_config_from_structure(&config, NULL));
  gst_tensors_config_free(&config);
  CHECK(!gst_tensors_config_from_structure(NULL, NULL));
  make_garbage(&config);
  CHECK(!gst_tensors_config_from_caps(&config, NULL, TRUE));
  CHECK(config.info.num_tensors == 0 && config.info.extra == NULL);
  gst_tensors_config_free(&config);
  CHECK(!gst_tensors_config_from_caps(NULL, NULL, TRUE));
  CHECK(gst_tensors_config_to_string(NULL) == NULL);
}

static void check_peer(void) {
  GstTensorsConfig config;
  gboolean fixed = TRUE;
  GstCaps* caps = gst_caps_from_string(
      "other/tensor, dimension=(string)3:4, type=(string)int8, framerate=(fraction)30/1");
  GstPadTemplate* open_template = gst_pad_template_new(
      "sink", GST_PAD_SINK, GST_PAD_ALWAYS,
      gst_caps_from_string("other/tensor, dimension=(string)7, type=(string)int8, "
                           "framerate=(fraction)[0/1, 30/1]"));
  GstPad* source = gst_pad_new("src", GST_PAD_SRC);
  GstPad* sink = gst_pad_new_from_template(open_template, "sink");
  make_garbage(&config);
  CHECK(!gst_tensors_config_from_peer(source, &config, &fixed));
  CHECK(!fixed);
  gst_tensors_config_free(&config);
  CHECK(gst_pad_link(source, sink) == GST_PAD_LINK_OK);
  fixed = TRUE;
  CHECK(gst_tensors_config_from_peer(source, &config, &fixed));
  CHECK(!fixed);
  CHECK(config.info.info[0].dimension[0] == 7);
  gst_tensors_config_free(&config);
  gst_pad_unlink(source, sink);
  gst_object_unref(sink);
  gst_object_unref(open_template);
  sink = gst_pad_new("sink", GST_PAD_SINK);
  CHECK(gst_pad_link(source, sink) == GST_PAD_LINK_OK);
  gst_pad_set_active(source, TRUE);
  gst_pad_set_active(sink, TRUE);
  gst_pad_push_event(source, gst_event_new_stream_start("id"));
  gst_pad_push_event(source, gst_event_new_caps(caps));
  CHECK(gst_tensors_config_from_peer(source, &config, &fixed));
  CHECK(fixed);
  CHECK(config.info.info[0].dimension[1] == 4 && config.rate_n == 30);
  gst_tensors_config_free(&config);
  CHECK(gst_tensors_config_from_peer(sink, &config, NULL));
  gst_tensors_config_free(&config);
  make_garbage(&config);
  CHECK(!gst_tensors_config_from_peer(NULL, &config, &fixed));
  CHECK(!fixed);
  gst_tensors_config_free(&config);
  CHECK(!gst_tensors_config_from_peer(source, NULL, NULL));
  gst_pad_set_active(source, FALSE);
  gst_pad_set_active(sink, FALSE);
  gst_caps_unref(caps);
  gst_object_unref(source);
  gst_object_unref(sink);
}

static void check_info_text(void) {
  GstTensorsInfo one, other;
  GstTensorInfo copy;
  gst_tensors_info_init(&one);
  gst_tensors_info_init(&other);
  one.num_tensors = gst_tensors_info_parse_dimensions_string(&one, "3:4:5,7:1");
  gst_tensors_info_parse_types_string(&one, "uint8,float32");
  gst_tensors_info_parse_names_string(&one, "image,");
  other.num_tensors = gst_tensors_info_parse_dimensions_string(&other, "3:4:5:1");
  gst_tensors_info_parse_types_string(&other, "uint8");
  CHECK(is(gst_tensor_info_to_string(&one.info[0]), "'image' uint8 (3:4:5)"));
  CHECK(is(gst_tensors_info_to_string(&one),
           "Format = static, Num_Tensors = 2, Tensors = [{ 'image' uint8 (3:4:5) }, { float32 "
           "(7:1) }]"));
  CHECK(gst_tensor_info_to_string(NULL) == NULL);
  CHECK(gst_tensors_info_to_string(NULL) == NULL);
  CHECK(is(gst_tensors_info_compare_to_string(&one, &other),
           "  0 : 'image' uint8 (3:4:5) | uint8 (3:4:5:1) Not equal\n"
           "  1 : float32 (7:1) | None Not equal\n"));
  CHECK(is(gst_tensors_info_compare_to_string(&other, &other),
           "  0 : uint8 (3:4:5:1) | uint8 (3:4:5:1) \n"));
  CHECK(gst_tensors_info_compare_to_string(&one, NULL) == NULL);
  CHECK(gst_tensors_info_compare_to_string(NULL, &one) == NULL);
  CHECK(is(gst_tensors_info_get_rank_dimensions_string(&one, 4, TRUE), "3:4:5:1,7:1:1:1"));
  CHECK(is(gst_tensors_info_get_rank_dimensions_string(&one, 4, FALSE), "3:4:5,7:1"));
  CHECK(is(gst_tensors_info_get_rank_dimensions_string(&one, 1, FALSE), "3,7"));
  CHECK(gst_tensors_info_get_rank_dimensions_string(NULL, 4, TRUE) == NULL);
  gst_tensor_info_copy_n(&copy, &one.info[0], 2);
  CHECK(copy.dimension[0] == 3 && copy.dimension[1] == 4 && copy.dimension[2] == 0);
  CHECK(copy.type == _NNS_UINT8 && copy.name != one.info[0].name && !strcmp(copy.name, "image"));
  gst_tensor_info_free(&copy);
  gst_tensor_info_copy_n(&copy, &one.info[0], 99);
  CHECK(gst_tensor_info_is_equal(&copy, &one.info[0]));
  gst_tensor_info_free(&copy);
  gst_tensor_info_copy_n(NULL, &one.info[0], 1);
  gst_tensor_info_copy_n(&copy, NULL, 1);
  gst_tensors_info_free(&one);
  gst_tensors_info_free(&other);
}

/* The text of more tensors than there can be. */
static void check_text_of_too_many(void) {
  GString* wanted = g_string_new(
      "Format = static, Num_Tensors = 257 (Num_Tensors out of bound, showing 256 only.), "
      "Tensors = [");
  GstTensorsInfo many;
  guint i;
  gst_tensors_info_init(&many);
  many.num_tensors = 257;
  gst_tensors_info_get_nth_info(&many, 0)->type = _NNS_UINT8;
  for (i = 0; i < 256; ++i) g_string_append(wanted, i ? "{ (null) () }, " : "{ uint8 () }, ");
  g_string_append(wanted, "]");
  CHECK(is(gst_tensors_info_to_string(&many), wanted->str));
  many.num_tensors = 0;
  CHECK(is(gst_tensors_info_to_string(&many), "Format = static, Num_Tensors = 0"));
  many.format = _NNS_TENSOR_FORMAT_END;
  CHECK(is(gst_tensors_info_to_string(&many), "Format = unknown"));
  gst_tensors_info_free(&many);
  g_string_free(wanted, TRUE);
}

/* Whether the first caps are caps of which the second are some. */
static int holds(const char* text, const char* some_text) {
  GstCaps *caps = gst_caps_from_string(text), *some = gst_caps_from_string(some_text);
  const int result = caps && some && gst_caps_is_subset(some, caps);
  if (caps) gst_caps_unref(caps);
  if (some) gst_caps_unref(some);
  return result;
}

static void check_caps_literals(void) {
  CHECK(holds(GST_TENSOR_CAP_DEFAULT ", type = " GST_TENSOR_TYPE_ALL,
              "other/tensor, type = float16, framerate = 30/1"));
  CHECK(holds(GST_TENSORS_CAP_DEFAULT,
              "other/tensors, format = static, num_tensors = 256, framerate = 0/1"));
  CHECK(!holds(GST_TENSORS_CAP_WITH_NUM("3"),
               "other/tensors, format = static, num_tensors = 2, framerate = 0/1"));
  CHECK(holds(GST_TENSORS_CAP_MAKE(GST_TENSOR_FORMAT_ALL),
              GST_TENSORS_FLEX_CAP_DEFAULT "; " GST_TENSORS_SPARSE_CAP_DEFAULT));
}

static void check_dimensions(void) {
  tensor_dim dim;
  CHECK(gst_tensor_parse_dimension("5U:7x:2 b", dim) == 3);
  CHECK(dim[0] == 5 && dim[1] == 7 && dim[2] == 2 && dim[3] == 0);
  CHECK(gst_tensor_parse_dimension("u5:7", dim) == 0);
  CHECK(dim[0] == 0 && dim[1] == 7);
  CHECK(gst_tensor_dimension_get_min_rank(dim) == 0);
  CHECK(gst_tensor_parse_dimension("3:4:1:1", dim) == 4);
  CHECK(gst_tensor_dimension_get_min_rank(dim) == 2);
  CHECK(is(gst_tensor_get_rank_dimension_string(dim, 6, TRUE), "3:4:1:1:1:1"));
  CHECK(is(gst_tensor_get_rank_dimension_string(dim, 6, FALSE), "3:4:1:1"));
  CHECK(is(gst_tensor_get_rank_dimension_string(dim, 2, TRUE), "3:4"));
  CHECK(is(gst_tensor_get_rank_dimension_string(dim, 0, TRUE), "3:4:1:1"));
  CHECK(is(gst_tensor_get_rank_dimension_string(dim, 17, FALSE), "3:4:1:1"));
  CHECK(gst_tensor_get_rank_dimension_string(NULL, 4, TRUE) == NULL);
  CHECK(gst_tensor_parse_dimension("1:1", dim) == 2);
  CHECK(gst_tensor_dimension_get_min_rank(dim) == 1);
  CHECK(gst_tensor_dimension_get_min_rank(NULL) == 0);
  CHECK(gst_tensor_dimension_string_is_equal("3:4", "3:4:1:1"));
  CHECK(gst_tensor_dimension_string_is_equal("3:4,5", "3:4:1.5:1"));
  CHECK(!gst_tensor_dimension_string_is_equal("3:4", "3:5"));
  CHECK(!gst_tensor_dimension_string_is_equal("3:4", "3:4,5"));
  CHECK(!gst_tensor_dimension_string_is_equal("3:0:4", "3:0:4"));
  CHECK(!gst_tensor_dimension_string_is_equal("", ""));
  CHECK(!gst_tensor_dimension_string_is_equal("3:4", NULL));
  CHECK(!gst_tensor_dimension_string_is_equal(NULL, "3:4"));
  CHECK(gst_tensor_get_format("STATIC") == _NNS_TENSOR_FORMAT_STATIC);
  CHECK(gst_tensor_get_format("flexible") == _NNS_TENSOR_FORMAT_FLEXIBLE);
  CHECK(gst_tensor_get_format("Sparse") == _NNS_TENSOR_FORMAT_SPARSE);
  CHECK(gst_tensor_get_format("dense") == _NNS_TENSOR_FORMAT_END);
  CHECK(gst_tensor_get_format(NULL) == _NNS_TENSOR_FORMAT_END);
  CHECK(!strcmp(gst_tensor_get_format_string(_NNS_TENSOR_FORMAT_STATIC), "static"));
  CHECK(!strcmp(gst_tensor_get_format_string(_NNS_TENSOR_FORMAT_SPARSE), "sparse"));
  CHECK(gst_tensor_get_format_string(_NNS_TENSOR_FORMAT_END) == NULL);
}

static void check_memory(void) {
  GstTensorMetaInfo meta, read;
  GstTensorInfo info;
  GstMapInfo map;
  GstMemory *data = gst_memory_new_wrapped(GST_MEMORY_FLAG_READONLY, (gpointer) "abcdef", 6, 0, 6,
                                           NULL, NULL),
            *whole;
  gst_tensor_info_init(&info);
  info.type = _NNS_UINT8;
  gst_tensor_parse_dimension("6", info.dimension);
  CHECK(gst_tensor_info_convert_to_meta(&info, &meta));
  whole = gst_tensor_meta_info_append_header(&meta, data);
  CHECK(whole != NULL);
  CHECK(gst_memory_map(whole, &map, GST_MAP_READ));
  CHECK(map.size == 134 && !memcmp(map.data + 128, "abcdef", 6));
  CHECK(map.data[0] == 0xed && map.data[3] == 0xfe);
  gst_memory_unmap(whole, &map);
  CHECK(gst_tensor_meta_info_parse_memory(&read, whole));
  CHECK(!memcmp(&read, &meta, sizeof meta));
  CHECK(!gst_tensor_meta_info_parse_memory(&read, data));
  CHECK(!gst_tensor_meta_info_parse_memory(&read, NULL));
  CHECK(!gst_tensor_meta_info_parse_memory(NULL, whole));
  CHECK(gst_tensor_meta_info_append_header(&meta, NULL) == NULL);
  CHECK(gst_tensor_meta_info_append_header(NULL, data) == NULL);
  meta.magic = 0;
  CHECK(gst_tensor_meta_info_append_header(&meta, data) == NULL);
  gst_memory_unref(whole);
  gst_memory_unref(data);
}

static void check_caps(void) {
  GstCaps* one = gst_caps_from_string(
      "other/tensors, format=(string)static, num_tensors=(int)2, dimensions=(string)\"3:4,5\", "
      "types=(string)\"uint8,uint8\", framerate=(fraction)[0/1, 30/1]");
  GstCaps* other = gst_caps_from_string(
      "other/tensors, format=(string)static, num_tensors=(int)2, "
      "dimensions=(string)\"3:4:1:1,5:1\", types=(string)\"uint8,uint8\", "
      "framerate=(fraction)30/1");
  GstCaps* slower = gst_caps_copy(other);
  GstCaps* tensor = gst_caps_from_string("other/tensor, dimension=(string)3:4:1:1");
  CHECK(!gst_caps_can_intersect(one, other));
  CHECK(gst_tensor_caps_can_intersect(one, other));
  CHECK(gst_tensor_caps_can_intersect(other, other));
  gst_caps_set_simple(slower, "framerate", GST_TYPE_FRACTION, 60, 1, NULL);
  CHECK(!gst_tensor_caps_can_intersect(one, slower));
  CHECK(!gst_tensor_caps_can_intersect(one, tensor));
  CHECK(!gst_tensor_caps_can_intersect(one, NULL));
  CHECK(!gst_tensor_caps_can_intersect(NULL, one));
  gst_tensor_caps_update_dimension(one, tensor);
  CHECK(!strcmp(gst_structure_get_string(gst_caps_get_structure(one, 0), "dimensions"), "3:4,5"));
  gst_tensor_caps_update_dimension(one, other);
  CHECK(!strcmp(gst_structure_get_string(gst_caps_get_structure(one, 0), "dimensions"),
                "3:4:1:1,5:1"));
  CHECK(gst_caps_can_intersect(one, other));
  gst_tensor_caps_update_dimension(one, NULL);
  gst_tensor_caps_update_dimension(NULL, other);
  gst_caps_unref(one);
  gst_caps_unref(other);
  gst_caps_unref(slower);
  gst_caps_unref(tensor);
}

static gboolean default_memory_is_at_a_multiple_of(gsize bytes) {
  GstMemory* memory = gst_allocator_alloc(NULL, 100, NULL);
  GstMapInfo map;
  gboolean multiple;
  if (!gst_memory_map(memory, &map, GST_MAP_READ)) return FALSE;
  multiple = ((guintptr)map.data) % bytes == 0;
  gst_memory_unmap(memory, &map);
  gst_memory_unref(memory);
  return multiple;
}

/* Memory that the library itself allocates for a tensor. */
static gboolean tensor_memory_is_at_a_multiple_of(gsize bytes) {
  GstTensorInfo info;
  GstTensorMetaInfo meta;
  GstMemory *data = gst_allocator_alloc(NULL, 10000, NULL), *whole;
  GstMapInfo map;
  gboolean multiple = FALSE;
  gst_tensor_info_init(&info);
  info.type = _NNS_UINT8;
  info.dimension[0] = 10000;
  gst_tensor_info_convert_to_meta(&info, &meta);
  whole = gst_tensor_meta_info_append_header(&meta, data);
  if (whole && gst_memory_map(whole, &map, GST_MAP_READ)) {
    multiple = ((guintptr)map.data) % bytes == 0;
    gst_memory_unmap(whole, &map);
  }
  if (whole) gst_memory_unref(whole);
  gst_memory_unref(data);
  return multiple;
}

static void check_allocator(void) {
  int i;
  gst_tensor_alloc_init(0);
  gst_tensor_alloc_init(4096);
  for (i = 0; i < 8; ++i) CHECK(default_memory_is_at_a_multiple_of(4096));
  gst_tensor_alloc_init(100); /* neither a power of two nor a mask: no effect */
  CHECK(default_memory_is_at_a_multiple_of(4096));
  gst_tensor_alloc_init(8191);
  for (i = 0; i < 8; ++i) CHECK(default_memory_is_at_a_multiple_of(8192));
  CHECK(tensor_memory_is_at_a_multiple_of(8192));
  gst_tensor_alloc_init(16);
  CHECK(default_memory_is_at_a_multiple_of(16));
}

static void check_accelerators(void) {
  const char* supported[] = {"gpu", "cpu.simd", NULL};
  parse_accl_args args = {"true:npu,cpu.neon", supported, "gpu", "cpu"};
  CHECK(parse_accl_hw_fill(args) == ACCL_CPU_SIMD);
  args.in_accl = NULL;
  CHECK(parse_accl_hw_fill(args) == ACCL_CPU);
  args.in_accl = "false";
  CHECK(parse_accl_hw_fill(args) == ACCL_NONE);
  CHECK(parse_accl_hw("true:npu", supported, "cpu", "gpu") == ACCL_CPU);
  CHECK(parse_accl_hw("true:npu", supported, NULL, NULL) == ACCL_GPU);
  CHECK(parse_accl_hw("true:npu.edgetpu") == ACCL_NPU_EDGETPU);
  CHECK(parse_accl_hw("maybe", supported) == ACCL_NONE);
}

static void check_frameworks(void) {
  const gchar* pt[] = {"model.PT"};
  const gchar* unknown[] = {"model.unknown"};
  const gchar* bare[] = {"model"};
  const gchar* two[] = {"a.so", "b.nb"};
  const gchar* null[] = {NULL};
  const gchar* folder[] = {"/"};
  CHECK(is(gst_tensor_filter_detect_framework(pt, 1, TRUE), "pytorch"));
  CHECK(is(gst_tensor_filter_detect_framework(two, 2, FALSE), "vivante"));
  CHECK(is(gst_tensor_filter_detect_framework(folder, 1, FALSE), "nnfw"));
  CHECK(gst_tensor_filter_detect_framework(unknown, 1, TRUE) == NULL);
  CHECK(gst_tensor_filter_detect_framework(bare, 1, FALSE) == NULL);
  CHECK(gst_tensor_filter_detect_framework(null, 1, FALSE) == NULL);
  CHECK(gst_tensor_filter_detect_framework(pt, 0, FALSE) == NULL);
  CHECK(gst_tensor_filter_detect_framework(NULL, 1, FALSE) == NULL);
  CHECK(gst_tensor_filter_check_hw_availability("custom-easy", ACCL_CPU, NULL));
  CHECK(!gst_tensor_filter_check_hw_availability("custom-easy", ACCL_NPU_SLSI, NULL));
  CHECK(!gst_tensor_filter_check_hw_availability("no-such-framework", ACCL_CPU, NULL));
  CHECK(!gst_tensor_filter_check_hw_availability(NULL, ACCL_CPU, NULL));
}

static void check_configuration(void) {
  gchar* folder = g_dir_make_tmp(NULL, NULL);
  gchar* file = g_build_filename(folder, "nnstreamer.ini", NULL);
  CHECK(g_file_set_contents(file,
                            "[common]\nenable_envvar=True\n[mine]\nword=two words\nyes=On\nno=0\n"
                            "perhaps=maybe\n[filter]\nframework_priority_mine=ncnn,other\n",
                            -1, NULL));
  g_setenv("NNSTREAMER_CONF", file, TRUE);
  CHECK(is(nnsconf_get_custom_value_string("mine", "word"), "two words"));
  CHECK(nnsconf_get_custom_value_string("mine", "other") == NULL);
  CHECK(nnsconf_get_custom_value_string("other", "word") == NULL);
  CHECK(nnsconf_get_custom_value_string(NULL, "word") == NULL);
  CHECK(nnsconf_get_custom_value_string("mine", NULL) == NULL);
  CHECK(nnsconf_get_custom_value_bool("mine", "yes", FALSE));
  CHECK(!nnsconf_get_custom_value_bool("mine", "no", TRUE));
  CHECK(nnsconf_get_custom_value_bool("mine", "perhaps", TRUE));
  CHECK(!nnsconf_get_custom_value_bool("mine", "perhaps", FALSE));
  CHECK(nnsconf_get_custom_value_bool("mine", "missing", TRUE));
  CHECK(!nnsconf_get_custom_value_bool(NULL, "yes", FALSE));
  g_setenv("NNSTREAMER_mine_word", "another", TRUE);
  CHECK(is(nnsconf_get_custom_value_string("mine", "word"), "another"));
  g_unsetenv("NNSTREAMER_mine_word");
  remove(file);
  remove(folder);
  g_free(file);
  g_free(folder);
}

static void check_version(void) {
  guint major = 0, minor = 0, micro = 9;
  CHECK(is(nnstreamer_version_string(), "NNStreamer 2.7.0"));
  nnstreamer_version_fetch(&major, &minor, &micro);
  CHECK(major == 2 && minor == 7 && micro == 0);
}

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  check_lists();
  check_media();
  check_config();
  check_peer();
  check_info_text();
  check_text_of_too_many();
  check_caps_literals();
  check_dimensions();
  check_memory();
  check_caps();
  check_allocator();
  check_accelerators();
  check_frameworks();
  check_configuration();
  check_version();
  UNUSED(argv);
  if (!failed) printf("as wanted\n");
  return failed != 0;
}
