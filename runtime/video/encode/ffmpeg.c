/* daft_film.so: what it exports. */
#include "video/encode/ffmpeg.h"

DAFT_API const film_module daft_film = {
    .encoder_open = ffmpeg_encoder_open,
    .encoder_add = ffmpeg_encoder_add,
    .encoder_finish = ffmpeg_encoder_finish,
    .encoder_close = ffmpeg_encoder_close,
    .muxer_open = ffmpeg_muxer_open,
    .muxer_add = ffmpeg_muxer_add,
    .muxer_commit = ffmpeg_muxer_commit,
    .muxer_abandon = ffmpeg_muxer_abandon,
    .soundtrack_open = ffmpeg_soundtrack_open,
    .soundtrack_add = ffmpeg_soundtrack_add,
    .soundtrack_finish = ffmpeg_soundtrack_finish,
    .soundtrack_close = ffmpeg_soundtrack_close,
};
