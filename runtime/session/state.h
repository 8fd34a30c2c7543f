/* state: what the parts of a session share. picture.c draws it, keys.c takes what the player does, changes.c what is
 * saved to the game's files, replay.c and output.c are its files, and session.c runs them in turn. */
#ifndef RUNTIME_SESSION_STATE_H
#define RUNTIME_SESSION_STATE_H

#include "session/session.h"
#include "tools/tools.h"

#include "accuracy/probe.h"
#include "files/saves.h"
#include "files/watch.h"
#include "game/agree.h"
#include "game/governor.h"
#include "game/loop.h"
#include "game/pause.h"
#include "game/relive.h"
#include "hud/graph.h"
#include "game/timeline.h"
#include "sound/tape.h"

#include <stdatomic.h>

/* Time that the player holds (hold.c). */
typedef struct time_hold {
    timeline *line;       /* of the game that runs; NULL: nobody has asked for it yet */
    timeline *catches_up; /* with the game, from its start on; NULL: none does */
    uint64_t wanted;      /* the tick to go to, once it has */
    int way;              /* -1: F5 is down; 1: F6 is; 0 */
    uint64_t since_ns, moved_ns;
    double owed; /* ticks to go, below 1 */
    input hands; /* what the player holds meanwhile */
} time_hold;

/* Measures of the governor's rungs (survey.c). */
enum { SURVEY_ROUNDS = 5 };
typedef struct rung_survey {
    daft_image *whole, *reference;
    int next; /* measure: rung + GOVERNOR_RUNGS · round */
    int wait; /* frames until it */
    double ms[GOVERNOR_RUNGS][SURVEY_ROUNDS], error[GOVERNOR_RUNGS][SURVEY_ROUNDS];
} rung_survey;

typedef struct session {
    const session_def *def;
    const game_info *info;
    const game_source *source;
    governor pace;
    bool governs;
    double drawn_ms;            /* of the frame at work, and its updates */
    bool reused;                /* parts of the picture were as before, so it says little about its quality */
    game_state games[2], *play; /* the one that runs, and room for what takes its place */
    trail past;
    time_hold time;
    watch files;
    char notice[HOST_MESSAGE]; /* of a change of the files, over the picture; or empty */
    uint64_t notice_ns;        /* until when; 0: until it is right */
    recording replay;
    agreement agreed;
    recording_script scripts[RECORDING_SCRIPTS]; /* of scripts/ that the game has required */
    size_t script_count, script_told;            /* script_told: of these, how many the replay was compared with */
    recorder *record;
    tools tools;
    panels placed; /* of the picture at work */
    tape sounds;
    tracer *spans;
    saves *kept, *own; /* the game's; the program's */
    player_settings settings;
    pause_menu pause;
    key_map keys;        /* the player's */
    held_inputs held;    /* what the player holds */
    window_wish granted; /* the last; its icon is only compared */
    bool redraws;        /* while it pauses: the picture is to change */
    bool paced;          /* the player has set something in this session */
    daft_image *picture; /* the window's */
    daft_history *history;
    loop clock;
    uint64_t last_ns, began_ns;
    bool left, closed, overlay, xray, reported;
    bool priced; /* F2: the panel of prices is open */
    probe prices;
    uint64_t prices_rest_ns; /* until when the next measure waits */
    rung_survey survey;
    bool wants_reload, wants_shot, grabbed;
    frame_times times;
    frame_graph graph;                        /* for the overlay */
    profile profile;                          /* hot.c */
    uint64_t faded_ns;                        /* when it last was */
    double update_ms, frame_ms, turn_ms;      /* smoothed, for the overlay */
    uint64_t hashed, drawn, shot_done, turns; /* ticks */
    progress_bar bar;
    _Atomic uint64_t polled_ns; /* when events were last taken */
    atomic_bool leaving;        /* set by the watchdog's thread: Esc or the close button waits in the queue */
} session;

/* ---- picture.c ---- */

/* Draws the game, or the error that stopped it. */
bool session_draw(session *s, float alpha, daft_error *error);
bool session_can_edit(const session *s);
double session_smooth(double before, double now);

/* ---- prices.c ---- */

/* F2 opens and closes the panel of prices. */
void session_toggle_prices(session *s);
/* Before a picture is drawn: measures what another setting would cost in it. */
void session_measure_prices(session *s, daft_image *picture, float alpha);
void session_draw_prices(session *s);

/* ---- survey.c ---- */

/* Before a picture is drawn, or while the game pauses: measures one rung of the governor's where there is time for it.
 */
void session_survey(session *s, float alpha);

/* ---- keys.c ---- */

void session_take_events(session *s);
/* What the console and the inspector work on. */
tools_scene session_tools_scene(session *s, float alpha);
/* A message over the picture, for two seconds. */
void session_tell(session *s, const char *text);
/* As if the game's key for a new start were pressed. */
void session_restart(session *s);
void session_apply(session *s);
void session_load_keys(session *s);
/* The player's, unless this session was started with one and the player has set nothing since. */
quality_wish session_quality(const session *s);

/* ---- hold.c ---- */

bool session_holds_time(const session *s);
/* False: it is no key of this, or not while time runs. */
bool session_take_time_key(session *s, const input_event *event);
bool session_turn_held(session *s, daft_error *error);
/* Time runs on from where it is. */
void session_release_time(session *s);
void session_close_time(session *s);

/* ---- changes.c ---- */

/* What changed on the disk is what is played from here on. */
bool session_take_changes(session *s, daft_error *error);

/* ---- replay.c ---- */

/* The recording that is played, and the one that is made. */
bool session_open_replay(session *s, daft_error *error);
/* The game has required a module of scripts/. */
void session_required(void *user, const char *name, const char *text, size_t size);
/* Whether these are the ones that it was recorded with. */
bool session_compare_scripts(session *s, daft_error *error);
/* Whether the replay still does what was recorded. */
bool session_compare(session *s, daft_error *error);
uint64_t session_last_tick(const session *s);
double session_speed(const session *s);
/* Updates that are due after so many nanoseconds. */
int session_updates_due(session *s, uint64_t elapsed);
/* Without a window no clock but this one holds a replay back. */
void session_keep_pace(session *s);

/* ---- output.c ---- */

bool session_after_tick(session *s, daft_error *error);
bool session_at_end(session *s, daft_error *error);
/* Writes a picture to the current folder, named by the time. */
void session_user_shot(session *s);
/* Tells why the script has failed, once. */
void session_report(session *s);

#endif
