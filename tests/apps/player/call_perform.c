#define _GNU_SOURCE /* for MAP_ANONYMOUS */
#include "call_private.h"

#include "../common/gl.h"

#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#if defined(__x86_64__)
enum { REGISTERS = 6 };
#else
enum { REGISTERS = 8 };
#endif
enum { REALS = 8, STACK = CALL_MOST_ARGUMENTS - 6, UNUSED = 0xa5, LEFT_OUT = 0x5afe };

typedef uint64_t word;
typedef union {
    double real;
    float single;
    word bits;
} real;

int call_line;
unsigned long long call_names[26][CALL_SLOTS];
bool call_has_fixed_function;

static unsigned char *const memory = (unsigned char *)CALL_MEMORY;
/* Used bytes of the current call. */
static size_t lists_used, small_used;
static char output[1 << 16];
static size_t output_used;

void call_flush(void)
{
    for (size_t done = 0; done < output_used;) {
        ssize_t written = write(STDOUT_FILENO, output + done, output_used - done);
        if (written <= 0)
            break;
        done += (size_t)written;
    }
    output_used = 0;
}

void call_say(const char *format, ...)
{
    enum { LONGEST = 8192 };
    if (output_used + LONGEST > sizeof output)
        call_flush();
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(output + output_used, LONGEST, format, arguments);
    va_end(arguments);
    output_used += length < LONGEST ? (size_t)length : LONGEST - 1;
}

_Noreturn void call_fail(const char *message)
{
    call_flush();
    fprintf(stderr, "%s\n", message);
    exit(1);
}

static void crashed(int number)
{
    signal(number, SIG_DFL);
    char text[64];
    call_flush();
    int length = snprintf(text, sizeof text, "%d signal %d\n", call_line, number);
    if (write(STDOUT_FILENO, text, (size_t)length) < 0)
        _exit(2);
    _exit(1);
}

static void GLAPIENTRY heard(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length, const GLchar *message,
                             const void *user)
{
    (void)source, (void)type, (void)id, (void)severity, (void)length, (void)message, (void)user;
}

void call_setup(void)
{
    void *wanted = memory;
    if (mmap(wanted, CALL_MEMORY_SIZE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0) != wanted)
        call_fail("no memory");
    for (uint32_t i = 0; i < CALL_INPUT_SIZE / 4; i++)
        memcpy(memory + CALL_INPUT + 4 * i, &(uint32_t){i % 16}, 4);
    static const int signals[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGALRM, SIGTRAP};
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; i++)
        signal(signals[i], crashed);
}

/*
 * Returns a name for an empty slot that OpenGL never makes, also if the program uses the names of
 * other empty slots: then OpenGL makes the numbers that follow these.
 */
static unsigned unmade(int slot)
{
    return 0xf00000u + ((unsigned)slot << 16);
}

void call_begin(bool has_fixed_function)
{
    call_has_fixed_function = has_fixed_function;
    for (int kind = 0; kind < 26; kind++) {
        for (int slot = 0; slot < CALL_SLOTS; slot++)
            call_names[kind][slot] = unmade(slot);
    }
}

static unsigned long long *name_of(char letter, long long slot)
{
    return &call_names[(letter - 'a') % 26][slot & (CALL_SLOTS - 1)];
}

/* Allocates space in the lists of this call. */
static unsigned char *room(size_t size)
{
    if (lists_used + size > CALL_MEMORY_SIZE - CALL_LISTS)
        call_fail("the lists of a call are too long");
    unsigned char *start = memory + CALL_LISTS + lists_used;
    lists_used += (size + 15) & ~(size_t)15;
    return start;
}

/* Parses numbers, or slots as `t3`, until the list ends. */
static void *list_of(char type, const char *text)
{
    unsigned char *start = room(8 * (strlen(text) + 1)), *to = start;
    while (*text != '\0' && *text != ']') {
        char *end = NULL;
        if (type == 'f' || type == 'd') {
            double value = strtod(text, &end);
            float single = (float)value;
            memcpy(to, type == 'f' ? (void *)&single : &value, type == 'f' ? 4 : 8);
            to += type == 'f' ? 4 : 8;
        } else {
            char letter = type == 'n' ? *text++ : 0;
            long long value = strtoll(text, &end, 0);
            size_t size = type == 'b' ? 1 : type == 'h' ? 2 : type == 'l' ? 8 : 4;
            if (letter != 0)
                value = (long long)*name_of(letter, value);
            memcpy(to, &value, size);
            to += size;
        }
        if (end == text)
            call_fail("a list of something else than numbers");
        text = *end == ',' ? end + 1 : end;
    }
    return start;
}

/* Parses a string in which \s is a space and \n the end of a line. */
static char *string_of(const char *text, size_t length)
{
    char *start = (char *)room(length + 1), *to = start;
    for (size_t i = 0; i < length; i++) {
        if (text[i] == '\\' && i + 1 < length)
            *to++ = text[++i] == 's' ? ' ' : '\n';
        else
            *to++ = text[i];
    }
    *to = '\0';
    return start;
}

/* Parses strings that are separated by ^. */
static void *strings_of(const char *text)
{
    enum { MOST = 16 };
    char **list = (char **)(void *)room(MOST * sizeof *list);
    for (int i = 0; i < MOST; i++) {
        size_t length = strcspn(text, "^");
        list[i] = string_of(text, length);
        text += length + (text[length] == '^');
    }
    return list;
}

/* Whether a buffer is bound for which the call takes offsets instead of addresses. */
static bool is_bound(char letter)
{
    GLenum names[] = {['a' - 'a'] = GL_ARRAY_BUFFER_BINDING, ['e' - 'a'] = GL_ELEMENT_ARRAY_BUFFER_BINDING,
                      ['u' - 'a'] = GL_PIXEL_UNPACK_BUFFER_BINDING, ['p' - 'a'] = GL_PIXEL_PACK_BUFFER_BINDING,
                      ['i' - 'a'] = GL_DRAW_INDIRECT_BUFFER_BINDING};
    GLint buffer = 0;
    glGetIntegerv(names[letter - 'a'], &buffer);
    return buffer != 0;
}

static word pointer(const void *address)
{
    return (word)(uintptr_t)address;
}

static word area(char letter)
{
    switch (letter) {
    case 's': {
        unsigned char *start = memory + CALL_SMALL + small_used;
        if (small_used + CALL_SMALL_SIZE > CALL_BIG - CALL_SMALL)
            call_fail("too many areas");
        small_used += CALL_SMALL_SIZE;
        return pointer(memset(start, UNUSED, CALL_SMALL_SIZE));
    }
    case 'b':
        memset(memory + CALL_BIG, UNUSED, CALL_BIG_SIZE);
        return pointer(memory + CALL_BIG);
    case 'f':
        return pointer(memory + CALL_FEEDBACK);
    case 'c': {
        word address = 0;
        GLDEBUGPROC callback = heard;
        memcpy(&address, &callback, sizeof callback);
        return address;
    }
    default:
        return pointer(memory + CALL_UNREAD);
    }
}

static word value_of(const call_argument *argument)
{
    switch (argument->kind) {
    case '%':
        return *name_of(argument->letter, argument->number);
    case '@':
        if (is_bound(argument->letter))
            return (word)argument->number;
        if (argument->letter == 'p')
            return area('u');
        return pointer(memory + CALL_INPUT + CALL_INPUT_MARGIN + argument->number);
    case '&':
        return area(argument->letter);
    case '~':
        return pointer(memory + CALL_INPUT + CALL_INPUT_MARGIN + argument->number);
    case '[':
        return pointer(list_of(argument->letter, argument->text));
    case '\'':
        return pointer(string_of(argument->text, strlen(argument->text)));
    case '*':
        return pointer(strings_of(argument->text));
    case '>':
        return pointer(memset(room(4 * CALL_SLOTS), 0, 4 * CALL_SLOTS));
    default:
        return (word)argument->number;
    }
}

/* Calls a function with all registers from which a function may take parameters. */
static word jump(void *address, const word *whole, const real *reals, const word *stack)
{
#if defined(__x86_64__)
    typedef word (*function)(word, word, word, word, word, word, double, double, double, double, double, double, double,
                             double, word, word, word, word, word, word, word, word, word, word);
#else
    typedef word (*function)(word, word, word, word, word, word, word, word, double, double, double, double, double,
                             double, double, double, word, word, word, word, word, word, word, word, word, word);
#endif
    function call;
    memcpy(&call, &address, sizeof call);
    return call(whole[0], whole[1], whole[2], whole[3], whole[4], whole[5],
#if !defined(__x86_64__)
                whole[6], whole[7],
#endif
                reals[0].real, reals[1].real, reals[2].real, reals[3].real, reals[4].real, reals[5].real, reals[6].real,
                reals[7].real, stack[0], stack[1], stack[2], stack[3], stack[4], stack[5], stack[6], stack[7], stack[8],
                stack[9]);
}

static bool is_deletion(const call_function *function)
{
    return strncmp(function->name, "glDelete", 8) == 0;
}

static void forget(const call_argument *argument)
{
    if (argument->kind == '%') {
        *name_of(argument->letter, argument->number) = unmade((int)argument->number & (CALL_SLOTS - 1));
        return;
    }
    for (const char *text = argument->text; *text != '\0' && *text != ']'; text += strcspn(text, ",]"), text += *text == ',') {
        call_argument one = {.kind = '%', .letter = text[0], .number = strtoll(text + 1, NULL, 0)};
        forget(&one);
    }
}

/* Puts the names that OpenGL created into slots. */
static void note(const call_argument *argument, const void *made)
{
    const char *text = argument->text;
    for (size_t i = 0; *text != '\0' && i < CALL_SLOTS; i++) {
        uint32_t name = 0;
        memcpy(&name, (const unsigned char *)made + 4 * i, 4);
        if (name != 0)
            *name_of(text[0], strtoll(text + 1, NULL, 0)) = name;
        text += strcspn(text, ",");
        text += *text == ',';
    }
}

/*
 * Returns a number for a name that is the same in each run: its slot, or one number for all names
 * that have no slot any more.
 */
static word slot_of(char letter, word name)
{
    if (name == 0 || name == UNUSED * 0x01010101u)
        return name;
    for (int i = 0; i < CALL_SLOTS; i++) {
        if (call_names[(letter - 'a') % 26][i] == name)
            return 0x51070000u + (unsigned)i;
    }
    return 0x51078000u;
}

static void name_slots(char letter, unsigned char *bytes, size_t size)
{
    if (letter == 'P') {
        for (size_t i = 0; i < size; i += 8) {
            word address = 0;
            memcpy(&address, bytes + i, 8);
            bool is_ours = address >= CALL_MEMORY && address < CALL_MEMORY + CALL_MEMORY_SIZE;
            bool is_unused = address == UNUSED * 0x0101010101010101u;
            if (!is_ours && !is_unused && address >= 0x1000000)
                address = 1;
            memcpy(bytes + i, &address, 8);
        }
        return;
    }
    for (size_t i = 0; i < size; i += 4) {
        uint32_t name = 0;
        memcpy(&name, bytes + i, 4);
        name = (uint32_t)slot_of(letter, name);
        memcpy(bytes + i, &name, 4);
    }
}

static word digest(const unsigned char *bytes, size_t size)
{
    word all = 0;
    for (size_t i = 0; i < size; i += 8) {
        word part = 0;
        memcpy(&part, bytes + i, 8);
        all = (all ^ part) * 0x9e3779b97f4a7c15ULL;
        all ^= all >> 32;
    }
    return all;
}

/*
 * Text of the words that a call wrote, and the number of bytes up to the last one that it changed.
 */
static const char *words(const unsigned char *bytes, size_t size)
{
    static char text[1024];
    size_t used = 0, last = 0;
    for (size_t i = 0; i < size; i++)
        if (bytes[i] != UNUSED)
            last = i + 1;
    for (size_t i = 0; i < last && used + 16 < sizeof text; i += 4) {
        uint32_t part = 0;
        memcpy(&part, bytes + i, 4);
        used += (size_t)snprintf(text + used, sizeof text - used, "%x ", part);
    }
    snprintf(text + used, sizeof text - used, "(%zu)", last);
    return text;
}

static unsigned pending_errors(void)
{
    unsigned all = 0, error;
    for (int i = 0; i < 8 && (error = glGetError()) != GL_NO_ERROR; i++)
        all = all * 16 + (error & 15) + 1;
    return all;
}

static word result_of(const call *what, word raw)
{
    switch (what->result) {
    case 'b':
        return raw & 0xff;
    case 'i':
        return raw & 0xffffffffu;
    case 'p':
        return raw != 0;
    case 's':
        return (raw & 0x80000000u) != 0;
    case 'n': {
        word name = what->result_letter == 'y' ? raw : raw & 0xffffffffu;
        if (name != 0)
            *name_of(what->result_letter, what->result_slot) = name;
        return name != 0;
    }
    default:
        return 0;
    }
}

call_answer call_perform(const call *what, bool with_text)
{
    call_answer answer = {.text = ""};
    word whole[REGISTERS] = {0}, stack[STACK] = {0};
    real reals[REALS] = {{0}};
    int wholes = 0, singles = 0;
    unsigned char *written = NULL;
    size_t size = 0;
    lists_used = small_used = 0;
    if (what->function->is_draw && !call_is_safe(what->function)) {
        answer.result = LEFT_OUT;
        return answer;
    }
    for (int i = 0; i < what->count; i++) {
        const call_argument *argument = &what->arguments[i];
        if (argument->kind == 'f' || argument->kind == 'd') {
            if (singles == REALS)
                call_fail("too many numbers");
            if (argument->kind == 'f')
                reals[singles++].single = (float)argument->real;
            else
                reals[singles++].real = argument->real;
            continue;
        }
        word value = value_of(argument);
        if (wholes < REGISTERS)
            whole[wholes] = value;
        else
            stack[wholes - REGISTERS] = value;
        wholes++;
        if (argument->kind == '&' && argument->letter == 's') {
            written = memory + CALL_SMALL;
            size = small_used;
        } else if (argument->kind == '&' && argument->letter == 'b') {
            written = memory + CALL_BIG;
            size = CALL_BIG_SIZE;
        }
    }
    if (!call_arguments_are_safe(what->function, whole, REGISTERS > 6 ? whole[6] : stack[0])) {
        answer.result = LEFT_OUT;
        return answer;
    }
    answer.result = result_of(what, jump(what->function->address, whole, reals, stack));
    if (!what->is_quiet)
        answer.error = pending_errors();
    for (int i = 0, at = 0; i < what->count; i++) {
        const call_argument *argument = &what->arguments[i];
        bool is_real = argument->kind == 'f' || argument->kind == 'd';
        if (argument->kind == '>')
            note(argument, (const void *)(uintptr_t)(at < REGISTERS ? whole[at] : stack[at - REGISTERS]));
        else if (is_deletion(what->function) && (argument->kind == '%' || (argument->kind == '[' && argument->letter == 'n')))
            forget(argument);
        at += !is_real;
    }
    if (written != NULL) {
        if (what->names != 0)
            name_slots(what->names, written, size);
        answer.digest = digest(written, size);
        if (with_text)
            answer.text = words(written, size);
    }
    return answer;
}
