/* stop: how the program ends before its time: by SIGINT, SIGTERM or SIGHUP, or by stop_program, from any thread.
 *
 * A thread of its own waits for the signals, so that ending needs nobody's help: not the thread that draws, loads or
 * runs a game. It calls the one act that stop_set_act has registered (a game's session puts its recording in place),
 * removes the temporary files of what is being written, prints what standard output still holds, and ends the process.
 * A signal ends it by that signal, so that shells see 130, 143 or 129. A second signal, a second or more after the
 * first, ends it at once.
 *
 * Promises: this is the only state of the program that is not in some struct, since signals have no other place for it.
 * The end takes ten seconds at most, should a disk hang. */
#ifndef RUNTIME_COMMON_STOP_H
#define RUNTIME_COMMON_STOP_H

typedef void stop_act(void *user);

/* Watches for the signals from now on; to be called before other threads are made. Signals that were ignored at the
 * start stay so (nohup). Where no thread can be made, signals end the process as the system sees fit. */
void stop_open(void);

/* Before another program takes the place of this one: it is to receive signals as this one did. */
void stop_before_exec(void);

/* What must happen before an early end; NULL: nothing. It runs on another thread than this one. Does not return while
 * it runs, so what `user` points to may go afterwards. */
void stop_set_act(stop_act *act, void *user);

/* Ends the process. `message`: a line on standard error, without "daft: ", or NULL. */
_Noreturn void stop_program(int status, const char *message);

#endif
