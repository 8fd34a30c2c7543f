/* An EXR file (scan lines, ZIP) in memory, then in one go to its place. */
#include "channels/exr.h"

#include "common/util.h"

#include <openexr.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct memory_file {
    char *bytes;
    size_t size, capacity;
    char message[200]; /* the library's last one */
} memory_file;

/* The library goes back to fill in where its chunks are. */
static int64_t put(exr_const_context_t context, void *user, const void *bytes, uint64_t count, uint64_t at,
                   exr_stream_error_func_ptr_t tell)
{
    memory_file *file = user;
    const size_t end = (size_t)(at + count);
    if (end > file->capacity) {
        const size_t capacity = end + end / 2;
        char *more = realloc(file->bytes, capacity);
        if (!more) {
            tell(context, EXR_ERR_OUT_OF_MEMORY, "out of memory for the picture");
            return -1;
        }
        file->bytes = more, file->capacity = capacity;
    }
    if (at > file->size) memset(file->bytes + file->size, 0, (size_t)at - file->size);
    memcpy(file->bytes + at, bytes, (size_t)count);
    file->size = end > file->size ? end : file->size;
    return (int64_t)count;
}

static void take_message(exr_const_context_t context, exr_result_t code, const char *message)
{
    void *user = NULL;
    (void)code;
    if (exr_get_user_data(context, &user) == EXR_ERR_SUCCESS && user)
        snprintf(((memory_file *)user)->message, sizeof((memory_file *)user)->message, "%s", message);
}

static exr_result_t begin(exr_context_t context, const exr_channel *channels, int count, int width, int height)
{
    int part;
    exr_result_t result = exr_add_part(context, "daft", EXR_STORAGE_SCANLINE, &part);
    if (result == EXR_ERR_SUCCESS)
        result = exr_initialize_required_attr_simple(context, 0, width, height, EXR_COMPRESSION_ZIP);
    for (int i = 0; result == EXR_ERR_SUCCESS && i < count; i++)
        result = exr_add_channel(context, 0, channels[i].name, channels[i].is_float ? EXR_PIXEL_FLOAT : EXR_PIXEL_UINT,
                                 EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    return result == EXR_ERR_SUCCESS ? exr_write_header(context) : result;
}

static exr_result_t encode(exr_context_t context, exr_encode_pipeline_t *encoder, const exr_channel *channels,
                           size_t row, size_t width, bool first)
{
    for (int i = 0; i < encoder->channel_count; i++) {
        exr_coding_channel_info_t *to = &encoder->channels[i];
        to->encode_from_ptr = (const uint8_t *)channels[i].first + row * width * (size_t)channels[i].step;
        to->user_pixel_stride = channels[i].step;
        to->user_line_stride = (int32_t)width * channels[i].step;
        to->user_bytes_per_element = 4;
        to->user_data_type = (uint16_t)(channels[i].is_float ? EXR_PIXEL_FLOAT : EXR_PIXEL_UINT);
    }
    exr_result_t result = first ? exr_encoding_choose_default_routines(context, 0, encoder) : EXR_ERR_SUCCESS;
    return result == EXR_ERR_SUCCESS ? exr_encoding_run(context, 0, encoder) : result;
}

static exr_result_t put_rows(exr_context_t context, const exr_channel *channels, int width, int height)
{
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t rows;
    exr_result_t result = exr_get_scanlines_per_chunk(context, 0, &rows);
    bool began = false;
    for (int y = 0; result == EXR_ERR_SUCCESS && y < height; y += rows) {
        exr_chunk_info_t chunk;
        result = exr_write_scanline_chunk_info(context, 0, y, &chunk);
        if (result != EXR_ERR_SUCCESS) break;
        result = began ? exr_encoding_update(context, 0, &chunk, &encoder)
                       : exr_encoding_initialize(context, 0, &chunk, &encoder);
        if (result == EXR_ERR_SUCCESS) result = encode(context, &encoder, channels, (size_t)y, (size_t)width, !began);
        began = true;
    }
    if (began) exr_encoding_destroy(context, &encoder);
    return result;
}

bool exr_write(const char *path, const exr_channel *channels, int count, int width, int height, daft_error *error)
{
    memory_file file = {0};
    exr_context_t context = NULL;
    exr_context_initializer_t how = EXR_DEFAULT_CONTEXT_INITIALIZER;
    how.user_data = &file, how.write_fn = put, how.error_handler_fn = take_message;
    exr_result_t result = exr_start_write(&context, path, EXR_WRITE_FILE_DIRECTLY, &how);
    if (result == EXR_ERR_SUCCESS) result = begin(context, channels, count, width, height);
    if (result == EXR_ERR_SUCCESS) result = put_rows(context, channels, width, height);
    if (context) {
        const exr_result_t end = exr_finish(&context);
        if (result == EXR_ERR_SUCCESS) result = end;
    }
    bool good = result == EXR_ERR_SUCCESS
                    ? daft_write_file(path, file.bytes, file.size, error)
                    : fail_at(error, path, 0, 0, "OpenEXR: %s",
                              file.message[0] ? file.message : exr_get_default_error_message(result));
    free(file.bytes);
    return good;
}
