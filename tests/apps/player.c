/*
 * Plays OpenGL calls that `cupola-lab calls` wrote to files, and returns OpenGL's answers. The
 * argument is a file of questions. Each line of stdin names a file of calls, which is played in a
 * new context. docs/calls.md describes the format.
 */
#include "player/call.h"
#include "common/window.h"

#include <GL/gl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MOST_QUESTIONS = 8192, LINE = 65536, PATIENCE = 30 };

static call *questions;
static char **question_texts;
static int question_count;

static void add_question(const char *text)
{
    if (question_count == MOST_QUESTIONS)
        call_fail("too many questions");
    question_texts[question_count] = strdup(text);
    if (call_parse(strdup(text), &questions[question_count]))
        question_count++;
}

static void read_questions(const char *path)
{
    static char line[LINE];
    FILE *file = fopen(path, "r");
    if (file == NULL)
        call_fail(path);
    questions = calloc(MOST_QUESTIONS, sizeof *questions);
    question_texts = calloc(MOST_QUESTIONS, sizeof *question_texts);
    while (fgets(line, sizeof line, file) != NULL) {
        line[strcspn(line, "\n")] = '\0';
        if (line[0] != '\0' && line[0] != '#')
            add_question(line);
    }
    fclose(file);
}

/* Asks all questions, and answers with one number for all or with a line for each. */
static void ask(int number, bool each)
{
    unsigned long long all = 0;
    for (int i = 0; i < question_count; i++) {
        call_answer answer = call_perform(&questions[i], each);
        if (each)
            call_say("%d %s = %x %llx %llx %s\n", number, question_texts[i], answer.error, answer.result, answer.digest,
                     answer.text);
        all = (all ^ answer.digest ^ answer.result ^ answer.error) * 0x9e3779b97f4a7c15ULL;
        all ^= all >> 29;
    }
    if (!each)
        call_say("%d asked %llx\n", number, all);
}

static window open_context(Display *display, const char *kind)
{
    window_request request = {.api = API_GL_COMPATIBILITY, .width = 64, .height = 64};
    if (strncmp(kind, "core", 4) == 0)
        request.api = API_GL_CORE, request.major = 4, request.minor = 5;
    else if (strncmp(kind, "es", 2) == 0)
        request.api = API_GLES, request.major = kind[2] - '0';
    const window base = {.display = display};
    return window_open_beside(&base, &request);
}

static void play(Display *display, const char *path)
{
    static char line[LINE];
    static call now;
    bool is_open = false, each = false;
    window w;
    FILE *file = fopen(path, "r");
    if (file == NULL)
        call_fail(path);
    for (int number = 1; fgets(line, sizeof line, file) != NULL; number++) {
        line[strcspn(line, "\n")] = '\0';
        call_line = number;
        if (strncmp(line, "context ", 8) == 0 && !is_open) {
            w = open_context(display, line + 8);
            is_open = true;
            call_begin(strncmp(line + 8, "compatibility", 13) == 0);
            call_say("%d %s\n", number, (const char *)glGetString(GL_VERSION));
        } else if (!is_open || line[0] == '\0' || line[0] == '#') {
            continue;
        } else if (strcmp(line, "each") == 0) {
            each = true;
        } else if (strcmp(line, "ask") == 0) {
            ask(number, each);
        } else if (strcmp(line, "swap") == 0) {
            window_swap(&w);
            call_say("%d swap %x\n", number, glGetError());
        } else if (call_parse(line, &now)) {
            call_answer answer = call_perform(&now, each);
            call_say("%d %x %llx %llx%s%s\n", number, answer.error, answer.result, answer.digest, each ? " " : "",
                     each ? answer.text : "");
        }
    }
    fclose(file);
    if (is_open)
        window_close(&w);
}

int main(int argc, char **argv)
{
    static char path[4096];
    Display *display = XOpenDisplay(NULL);
    if (display == NULL || argc != 2)
        call_fail("usage: player QUESTIONS, with a display");
    call_setup();
    read_questions(argv[1]);
    while (fgets(path, sizeof path, stdin) != NULL) {
        path[strcspn(path, "\n")] = '\0';
        alarm(PATIENCE);
        play(display, path);
        alarm(0);
        call_say("end\n");
        call_flush();
    }
    return 0;
}
