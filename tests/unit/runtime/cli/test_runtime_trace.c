/* runtime: traces: the ring, names with quotes, and the file's grammar. checks/trace.sh looks at what the program
 * writes. */
#include "common/trace.h"
#include "common/util.h"
#include "json.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include <unistd.h>

static char *read_trace(const char *path)
{
    size_t size;
    daft_error error;
    char *text = daft_read_file(NULL, path, &size, &error);
    if (!text) fail_msg("%s", error.message);
    const char *end = json_value(text);
    assert_true(end && *json_blanks(end) == 0);
    unlink(path);
    return text;
}

static int count(const char *text, const char *what)
{
    int found = 0;
    for (const char *at = text; (at = strstr(at, what)); at++) found++;
    return found;
}

static void the_newest_spans_are_kept(void **unused)
{
    (void)unused;
    static const char PATH[] = "/tmp/daft-trace-test.json";
    daft_error error;
    tracer *t = trace_open(PATH, 10, &error);
    assert_non_null(t);
    for (int i = 0; i < 25; i++) {
        char name[64];
        snprintf(name, sizeof name, "span %d \"%s\" and what is too long for a name", i, i % 2 ? "\\" : "\n");
        trace_end(t, name, trace_begin(t));
    }
    assert_true(trace_finish(t, &error));
    trace_end(t, "after the end", trace_begin(t));
    assert_true(trace_finish(t, &error));
    trace_free(t);
    char *text = read_trace(PATH);
    assert_int_equal(count(text, "\"ph\":\"X\""), 10);
    assert_int_equal(count(text, "after the end"), 0);
    assert_non_null(strstr(text, "span 15"));
    assert_non_null(strstr(text, "span 24"));
    assert_non_null(strstr(text, "\"spans_lost\":15"));
    free(text);
}

static void nobody_pays_where_nobody_traces(void **unused)
{
    (void)unused;
    daft_error error;
    assert_true(trace_begin(NULL) == 0);
    trace_end(NULL, "a", 0);
    trace_span(NULL, TRACE_MAIN, "a", 0, 0);
    trace_step(NULL, NULL, 0);
    trace_picture(NULL, NULL, 0);
    assert_true(trace_finish(NULL, &error));
    trace_free(NULL);
    tracer *t = trace_open("/nowhere/at/all.json", 10, &error);
    assert_false(trace_finish(t, &error));
    trace_free(t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_newest_spans_are_kept),
                                       cmocka_unit_test(nobody_pays_where_nobody_traces)};
    return cmocka_run_group_tests_name("trace", tests, NULL, NULL);
}
