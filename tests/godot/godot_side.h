// godot_side: what Godot offers to extensions, as far as ours uses it, with a count of what is not
// given back.
#pragma once

#include <gdextension_interface.h>
#include <stdio.h>
#include <stdlib.h>

#define CHECK(condition)                                                      \
    do {                                                                      \
        if (!(condition)) {                                                   \
            fprintf(stderr, "host.c:%d: not so: %s\n", __LINE__, #condition); \
            exit(1);                                                          \
        }                                                                     \
    } while (0)

#define STRING GDEXTENSION_VARIANT_TYPE_STRING
#define NAME GDEXTENSION_VARIANT_TYPE_STRING_NAME
#define BYTES GDEXTENSION_VARIANT_TYPE_PACKED_BYTE_ARRAY
#define INT GDEXTENSION_VARIANT_TYPE_INT
#define FLOAT GDEXTENSION_VARIANT_TYPE_FLOAT
#define BOOL GDEXTENSION_VARIANT_TYPE_BOOL
#define VECTOR3 GDEXTENSION_VARIANT_TYPE_VECTOR3
#define QUATERNION GDEXTENSION_VARIANT_TYPE_QUATERNION

/* A block of bytes, which String, StringName and PackedByteArray point to: the first from their
   first word, the last from their second one, as in Godot. */
typedef struct {
    int64_t size;
    uint8_t data[];
} block;

typedef struct {
    int type;
    int canary;

    union {
        block* text;
        block* bytes[2];
        int64_t integer;
        double number;
        GDExtensionBool truth;
        float part[4];
    } of;
} variant; /* of 24 bytes */

typedef struct {
    char name[64];
    GDExtensionClassMethodCall call;
    GDExtensionClassMethodPtrCall typed;
    void* data;
    int result;
    uint32_t count;
    int type[8];
} method;

typedef struct {
    GDExtensionClassInstancePtr instance;
} object;

extern int live;            /* blocks that somebody has yet to give back */
extern const char* without; /* the function that get_proc_address() does not know */
extern method methods[];
extern size_t method_count;
extern GDExtensionClassCreationInfo2 class_info;
extern int classes;
extern const GDExtensionClassLibraryPtr kLibrary;

GDExtensionInterfaceFunctionPtr get_proc_address(const char* name);
block* new_block(const void* data, int64_t size);
void drop(block** at);
/* Of a String or a StringName. */
const char* text_of(const void* string);
/* From Godot's own layout of the type. */
void to_variant(int type, variant* to, const void* from);
