/* Cupola: finished frames in shared memory.
 *
 * `cupola run --publish[=FILE]` lets a program write the finished pictures of each frame to a file in
 * shared memory, by default /dev/shm/cupola-USER with the number of the user. This header defines its
 * layout. It needs no library; examples/c/ring_reader.c is a reader.
 *
 * The file is an array of 64-bit words in the machine's byte order. Positions below count words.
 *
 *   header | readers | slot 0 | slot 1 | ... | slot n-1
 *
 * Frame k, counted from 0, lies in slot k modulo n. Words that processes share are read with acquire
 * order and written with release order, unless stated otherwise.
 *
 * A reader
 * 1. maps the file for reading and writing. The first two words must be CUPOLA_RING_MAGIC and
 *    CUPOLA_RING_VERSION. All positions and sizes have to be checked against the size of the file.
 * 2. looks for an entry whose state is not EXPECTED, and takes a lock on the first byte of the entry
 *    (fcntl, F_OFD_SETLK, F_WRLCK, one byte). If another process has the lock, it tries the next one.
 *    It sets LOST to 0, CURSOR to the word PUBLISHED of the header, and STATE to ACTIVE. After a full
 *    fence it sets CURSOR to PUBLISHED once more if that is larger. It adds 1 to TAKEN, and wakes it.
 * 3. waits until CURSOR is less than PUBLISHED. PUBLISHED is a futex: its low 32 bits are woken.
 * 4. reads CURSOR, k. The word SEQUENCE of its slot is 2k+2 if the frame is complete. It copies the
 *    frame, and after an acquire fence replaces CURSOR by k+1 with compare and exchange from k. If that
 *    fails, the writer has advanced CURSOR: the reader discards the copy, and LOST has grown. Otherwise
 *    it adds 1 to TAKEN, and wakes it.
 * 5. looks at STATE of the header when it has read everything. REPLACED: the sizes have changed. A new
 *    file has this file's name, and in it the reader's entry has the state EXPECTED: the reader takes the
 *    lock there and sets the state to ACTIVE, without changing CURSOR; if there is no file any more, the
 *    program has ended. ENDED: the program has ended. If
 *    nobody has the lock on the first byte of WRITER_LOCK, it has died without setting STATE.
 * 6. at the end sets its STATE to FREE, releases the lock, adds 1 to TAKEN, and wakes it.
 *
 * A program that waits for its readers (CUPOLA_PUBLISH_WAIT=1) loses no frame. Otherwise a reader
 * that is slower than the program loses frames, and the program never waits. While all entries are
 * FREE, it may publish only some of its frames, at least about ten a second if it draws so many. If
 * it draws no more, the newest frame is then up to 0.1 s older than the last one that it drew.
 */
#ifndef CUPOLA_RING_H
#define CUPOLA_RING_H

/* The first eight bytes of a file. */
#define CUPOLA_RING_MAGIC "CUPORING"
/* Grows when the layout changes. */
#define CUPOLA_RING_VERSION 1

/* Words of the header. */
#define CUPOLA_RING_HEADER_MAGIC 0
#define CUPOLA_RING_HEADER_VERSION 1
/* Number of slots, words of a slot, first word of the first slot. */
#define CUPOLA_RING_HEADER_SLOTS 2
#define CUPOLA_RING_HEADER_SLOT_WORDS 3
#define CUPOLA_RING_HEADER_FIRST_SLOT 4
/* Number of frames that were published. A futex. */
#define CUPOLA_RING_HEADER_PUBLISHED 5
#define CUPOLA_RING_HEADER_STATE 6
/* 1: the writer waits for its readers. */
#define CUPOLA_RING_HEADER_WAITS 7
/* Grows when a reader has advanced its cursor. A futex. */
#define CUPOLA_RING_HEADER_TAKEN 8
/* Number of the writer's process. */
#define CUPOLA_RING_HEADER_PROCESS 9
/* The writer has a lock on the first byte of this word while it lives. */
#define CUPOLA_RING_HEADER_WRITER_LOCK 10

/* States of the file. */
#define CUPOLA_RING_OPEN 0
#define CUPOLA_RING_REPLACED 1
#define CUPOLA_RING_ENDED 2

/* Number of readers, first word of the first one, words of each. */
#define CUPOLA_RING_READERS 16
#define CUPOLA_RING_FIRST_READER 64
#define CUPOLA_RING_READER_WORDS 8
/* Words of a reader. */
#define CUPOLA_RING_READER_STATE 0
/* Number of the frame that it copies next. */
#define CUPOLA_RING_READER_CURSOR 1
/* Number of frames that it lost. */
#define CUPOLA_RING_READER_LOST 2

/* States of a reader's entry. */
#define CUPOLA_RING_FREE 0
#define CUPOLA_RING_ACTIVE 1
#define CUPOLA_RING_EXPECTED 2

/* Words of a slot. */
/* 2k+1 while frame k is written, 2k+2 when it is complete. */
#define CUPOLA_RING_SLOT_SEQUENCE 0
/* The program's own number of the frame, from 1. */
#define CUPOLA_RING_SLOT_INDEX 1
/* Time of the frame on the program's monotonic clock, in nanoseconds. */
#define CUPOLA_RING_SLOT_TIME 2
/* Number of pictures, at most CUPOLA_RING_PICTURES. */
#define CUPOLA_RING_SLOT_PICTURES 3
/* FNV-1a checksum (64 bits) of the text of the rig's file that the frame shows. 0: not known, as for presets
 * and programs of earlier versions of Cupola. */
#define CUPOLA_RING_SLOT_RIG 4
/* First word of the table of pictures. */
#define CUPOLA_RING_SLOT_TABLE 8

#define CUPOLA_RING_PICTURES 64

/* Words of a picture in the table. */
/* Its name in UTF-8, CUPOLA_RING_NAME_BYTES bytes, filled with zeroes. */
#define CUPOLA_RING_PICTURE_NAME 0
/* Its first pixel, in words from the slot's first. */
#define CUPOLA_RING_PICTURE_PIXELS 8
/* Size in pixels. */
#define CUPOLA_RING_PICTURE_WIDTH 9
#define CUPOLA_RING_PICTURE_HEIGHT 10
#define CUPOLA_RING_PICTURE_FORMAT 11
/* Words of an entry of the table. */
#define CUPOLA_RING_PICTURE_WORDS 16

#define CUPOLA_RING_NAME_BYTES 64

/* Formats: red first, rows from the top, without gaps. A reader refuses a picture whose format it does
 * not know.
 * RGBA8: four bytes for each pixel, alpha is 255. RGBA16: four numbers of 16 bits for each pixel in the
 * machine's byte order, alpha is 65535; only with CUPOLA_PUBLISH_DEPTH=16. */
#define CUPOLA_RING_RGBA8 1
#define CUPOLA_RING_RGBA16 2

#endif
