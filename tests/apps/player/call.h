/*
 * An OpenGL call that is read from a line of text. docs/calls.md describes the format. x86-64 and
 * AArch64 only.
 */
#ifndef APPS_CALL_H
#define APPS_CALL_H

#include <stdbool.h>

enum { CALL_MOST_ARGUMENTS = 16 };

typedef struct {
    char kind;        /* kind as in the line's format */
    char letter;      /* letter of a kind of names, of a binding or of a type */
    long long number; /* value, slot or offset */
    double real;
    char *text; /* text of lists and strings; points into the line */
} call_argument;

typedef struct call_function call_function;

typedef struct {
    const call_function *function;
    char result;         /* v: none, b: 8 bits, i: 32 bits, s: sign, p: pointer, n: name */
    char result_letter;  /* kind of the returned names */
    int result_slot;
    char names;          /* kind of the names that the call writes, P for pointers, 0 for none */
    bool is_quiet;       /* no question about errors follows */
    int count;
    call_argument arguments[CALL_MOST_ARGUMENTS];
} call;

typedef struct {
    unsigned error;
    unsigned long long result, digest;
    const char *text; /* values that the call wrote, if they were asked for */
} call_answer;

/* Number of the line of the file that is played, for reports of crashes. */
extern int call_line;

void call_setup(void);
/* Call it when a context has become current: all names are new. */
void call_begin(bool has_fixed_function);
/* Parses a line. Returns whether it is a call. `into` points into the line. */
bool call_parse(char *line, call *into);
call_answer call_perform(const call *what, bool with_text);

/* Writes to the output. Output is buffered until it is long, and is also written in a crash. */
void call_say(const char *format, ...) __attribute__((format(printf, 1, 2)));
void call_flush(void);
_Noreturn void call_fail(const char *message);

#endif
