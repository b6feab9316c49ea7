#include "call_private.h"

#include "../common/gl.h"

#include <GL/glx.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_FUNCTIONS = 8192 };

static call_function functions[MOST_FUNCTIONS];

static bool starts(const char *text, const char *start)
{
    return strncmp(text, start, strlen(start)) == 0;
}

const call_function *call_find(const char *name)
{
    unsigned hash = 2166136261u;
    for (const char *c = name; *c != '\0'; c++)
        hash = (hash ^ (unsigned char)*c) * 16777619u;
    for (unsigned i = hash % MOST_FUNCTIONS;; i = (i + 1) % MOST_FUNCTIONS) {
        call_function *function = &functions[i];
        if (strcmp(function->name, name) == 0)
            return function;
        if (function->name[0] != '\0')
            continue;
        void (*address)(void) = glXGetProcAddressARB((const GLubyte *)name);
        if (strlen(name) >= sizeof function->name || address == NULL)
            call_fail(name);
        strcpy(function->name, name);
        memcpy(&function->address, &address, sizeof address);
        function->is_draw = (starts(name, "glDraw") && (strstr(name, "Arrays") != NULL || strstr(name, "Elements") != NULL)) ||
                            starts(name, "glMultiDraw") || starts(name, "glArrayElement") || starts(name, "glDrawTransform");
        function->takes_indices = strstr(name, "Elements") != NULL;
        function->is_read = starts(name, "glReadPixels");
        function->asks_program = starts(name, "glGetProgramiv") || starts(name, "glGetObjectParameteriv");
        function->asks_varying = starts(name, "glGetTransformFeedbackVarying");
        return function;
    }
}

static void parse_argument(char *text, call_argument *into)
{
    memset(into, 0, sizeof *into);
    into->kind = text[0];
    switch (text[0]) {
    case '%': /* a name */
    case '@': /* an offset, or an address where no buffer is bound */
        into->letter = text[1];
        into->number = strtoll(text + 2, NULL, 0);
        break;
    case 'f':
    case 'd':
        into->real = strtod(text + 1, NULL);
        break;
    case '&': /* an area */
        into->letter = text[1];
        break;
    case '~': /* an offset in the input */
        into->number = strtoll(text + 1, NULL, 0);
        break;
    case '[': /* a list of numbers or names */
        into->letter = text[1];
        into->text = text + 2;
        break;
    case '>': /* slots for names that are made */
    case '\'': /* a string */
    case '*': /* a list of strings */
        into->text = text + 1;
        break;
    default:
        into->kind = '0';
        into->number = text[0] == '-' ? strtoll(text, NULL, 0) : (long long)strtoull(text, NULL, 0);
    }
}

bool call_parse(char *line, call *into)
{
    char *rest = NULL, *word = strtok_r(line, " ", &rest);
    if (word == NULL)
        return false;
    into->result = *word++;
    into->names = 0;
    into->is_quiet = false;
    for (; *word != '\0'; word++) {
        if (*word == '-')
            into->is_quiet = true;
        else if (*word == '?' && word[1] != '\0')
            into->names = *++word;
        else if (*word == '=' && word[1] != '\0') {
            into->result_letter = *++word;
            into->result_slot = (int)strtol(word + 1, &word, 10) % CALL_SLOTS;
            word--;
        }
    }
    word = strtok_r(NULL, " ", &rest);
    if (word == NULL)
        return false;
    into->function = call_find(word);
    for (into->count = 0; into->count < CALL_MOST_ARGUMENTS; into->count++) {
        word = strtok_r(NULL, " ", &rest);
        if (word == NULL)
            break;
        parse_argument(word, &into->arguments[into->count]);
    }
    return true;
}
