/* ZonedClient: the client library as a class of Godot 4.2 and newer, by the C interface of
   extensions alone. In GDScript:

     var client := ZonedClient.new()
     client.connect_to_server("127.0.0.1", 7777, "ann")
     each frame:
       client.set_input(move_x, move_z, yaw, pitch, buttons)
       if client.poll(Time.get_ticks_usec() / 1000000.0) == 4: print(client.trouble())  # closed
       client.avatar_position(), client.entity_count(), client.entity_position(i), and draw

   Builds of Godot with single precision (as it is distributed): Vector3 and Quaternion hold floats.
 */
#include "client_node.h"
#include <stdlib.h>
#include <string.h>

#define CLASS_NAME "ZonedClient"
#define USAGE_DEFAULT 6 /* of a property: stored, and shown in the editor */

/* Signatures of built-in methods, as Godot's extension_api.json has them. */
#define HASH_SIZE 3173160232
#define HASH_RESIZE 848867239

/* Godot's String, StringName and PackedByteArray as they lie in memory. */
typedef struct {
    void* parts[2];
} opaque;

/* Functions of Godot. */
static struct {
    GDExtensionInterfacePrintError print_error;
    GDExtensionInterfaceVariantGetType variant_get_type;
    GDExtensionInterfaceGetVariantFromTypeConstructor variant_from_type;
    GDExtensionInterfaceGetVariantToTypeConstructor variant_to_type;
    GDExtensionInterfaceVariantGetPtrConstructor constructor;
    GDExtensionInterfaceVariantGetPtrDestructor destructor;
    GDExtensionInterfaceVariantGetPtrBuiltinMethod builtin_method;
    GDExtensionInterfaceStringNewWithUtf8CharsAndLen string_new;
    GDExtensionInterfaceStringToUtf8Chars string_to_utf8;
    GDExtensionInterfaceStringNameNewWithLatin1Chars string_name_new;
    GDExtensionInterfacePackedByteArrayOperatorIndex byte_at;
    GDExtensionInterfacePackedByteArrayOperatorIndexConst byte_at_const;
    GDExtensionInterfaceClassdbConstructObject construct_object;
    GDExtensionInterfaceObjectSetInstance set_instance;
    GDExtensionInterfaceClassdbRegisterExtensionClass2 register_class;
    GDExtensionInterfaceClassdbRegisterExtensionClassMethod register_method;
    GDExtensionInterfaceClassdbUnregisterExtensionClass unregister_class;
} godot;

static GDExtensionClassLibraryPtr library;
static GDExtensionPtrBuiltInMethod bytes_size;
static GDExtensionPtrBuiltInMethod bytes_resize;

/* ------------------------------------------------------------------ values from Godot and back */

/* Of a value in Godot's own layout; release() follows. */
static void take(int type, const void* from, value* to) {
    memset(to, 0, sizeof *to);
    switch (type) {
        case INT:
            memcpy(&to->integer, from, sizeof to->integer);
            break;
        case FLOAT:
            memcpy(&to->number, from, sizeof to->number);
            break;
        case STRING: {
            const GDExtensionInt size = godot.string_to_utf8(from, NULL, 0);
            char* const text = calloc((size_t)size + 1, 1);
            if (text != NULL) {
                godot.string_to_utf8(from, text, size);
                to->size = (size_t)size;
            }
            to->data = text;
            break;
        }
        case BYTES: {
            int64_t size = 0;
            bytes_size((void*)from, NULL, &size, 0);
            to->data = size > 0 ? copy_of(godot.byte_at_const(from, 0), (size_t)size) : NULL;
            to->size = to->data != NULL ? (size_t)size : 0;
            break;
        }
        default:
            break;
    }
}

static void release(int type, value* taken) {
    if (type == STRING || type == BYTES) {
        free((void*)taken->data);
    }
}

/* Into empty room in Godot's own layout. */
static void give(int type, const value* from, void* to) {
    switch (type) {
        case BOOL:
            memcpy(to, &from->truth, sizeof from->truth);
            break;
        case INT:
            memcpy(to, &from->integer, sizeof from->integer);
            break;
        case FLOAT:
            memcpy(to, &from->number, sizeof from->number);
            break;
        case STRING:
            godot.string_new(to, from->data != NULL ? from->data : "", (GDExtensionInt)from->size);
            break;
        case VECTOR3:
            memcpy(to, from->part, 3 * sizeof(float));
            break;
        case QUATERNION:
            memcpy(to, from->part, 4 * sizeof(float));
            break;
        case BYTES: {
            const int64_t size = (int64_t)from->size;
            const void* arguments[1] = {&size};
            int64_t result = 0;
            godot.constructor(BYTES, 0)(to, NULL);
            bytes_resize(to, arguments, &result, 1);
            if (size > 0 && result == 0) {
                memcpy(godot.byte_at(to, 0), from->data, from->size);
            }
            break;
        }
        default:
            break;
    }
}

static void run(const method* m, node* self, value* in, value* out) {
    int i;
    memset(out, 0, sizeof *out);
    for (i = 0; i < m->count; ++i) {
        if (m->type[i] == STRING && in[i].data == NULL) {
            return; /* no memory */
        }
    }
    m->run(self, in, out);
}

/* A call whose types Godot has checked. */
static void call_typed(void* data,
                       GDExtensionClassInstancePtr self,
                       const GDExtensionConstTypePtr* arguments,
                       GDExtensionTypePtr result) {
    const method* const m = data;
    value in[MOST_ARGUMENTS];
    value out;
    int i;
    for (i = 0; i < m->count; ++i) {
        take(m->type[i], arguments[i], &in[i]);
    }
    run(m, self, in, &out);
    give(m->result, &out, result);
    for (i = 0; i < m->count; ++i) {
        release(m->type[i], &in[i]);
    }
}

/* 1: taken from a Variant. An int is a float where one is wanted. */
static int take_variant(int type, GDExtensionConstVariantPtr from, value* to) {
    const int has = (int)godot.variant_get_type(from);
    opaque raw = {{0}};
    if (has != type && !(has == INT && type == FLOAT)) {
        return 0;
    }
    godot.variant_to_type((GDExtensionVariantType)has)(&raw, (void*)from);
    take(has, &raw, to);
    if (has != type) {
        to->number = (double)to->integer;
    }
    if (has == STRING || has == BYTES) {
        godot.destructor((GDExtensionVariantType)has)(&raw);
    }
    return 1;
}

static void give_variant(int type, const value* from, GDExtensionVariantPtr to) {
    opaque raw = {{0}};
    if (type == VOID) {
        return; /* Godot hands an empty one */
    }
    give(type, from, &raw);
    godot.variant_from_type((GDExtensionVariantType)type)(to, &raw);
    if (type == STRING || type == BYTES) {
        godot.destructor((GDExtensionVariantType)type)(&raw);
    }
}

/* A call with whatever a script has written. */
static void call_any(void* data,
                     GDExtensionClassInstancePtr self,
                     const GDExtensionConstVariantPtr* arguments,
                     GDExtensionInt count,
                     GDExtensionVariantPtr result,
                     GDExtensionCallError* error) {
    const method* const m = data;
    value in[MOST_ARGUMENTS];
    value out;
    int taken = 0;
    error->error = GDEXTENSION_CALL_OK;
    if (count != m->count) {
        error->error = count < m->count ? GDEXTENSION_CALL_ERROR_TOO_FEW_ARGUMENTS
                                        : GDEXTENSION_CALL_ERROR_TOO_MANY_ARGUMENTS;
        error->expected = m->count;
        return;
    }
    while (taken < m->count && take_variant(m->type[taken], arguments[taken], &in[taken])) {
        ++taken;
    }
    if (taken < m->count) {
        error->error = GDEXTENSION_CALL_ERROR_INVALID_ARGUMENT;
        error->argument = taken;
        error->expected = m->type[taken];
    } else {
        run(m, self, in, &out);
        give_variant(m->result, &out, result);
    }
    while (taken-- > 0) {
        release(m->type[taken], &in[taken]);
    }
}

/* ------------------------------------------------------------------ the class */

static opaque name_of(const char* text) {
    opaque name = {{0}};
    godot.string_name_new(&name, text, 0);
    return name;
}

static void forget(opaque* name) {
    godot.destructor(GDEXTENSION_VARIANT_TYPE_STRING_NAME)(name);
}

static GDExtensionObjectPtr create(void* data) {
    opaque parent = name_of("RefCounted");
    opaque name = name_of(CLASS_NAME);
    const GDExtensionObjectPtr object = godot.construct_object(&parent);
    node* const self = calloc(1, sizeof *self);
    (void)data;
    if (self == NULL) {
        abort(); /* as Godot itself does without memory */
    }
    godot.set_instance(object, &name, self);
    forget(&parent);
    forget(&name);
    return object;
}

static void destroy(void* data, GDExtensionClassInstancePtr instance) {
    (void)data;
    delete_node(instance);
}

static void describe(GDExtensionPropertyInfo* info,
                     int type,
                     opaque* name,
                     opaque* none,
                     opaque* hint) {
    info->type = (GDExtensionVariantType)type;
    info->name = name;
    info->class_name = none;
    info->hint = 0;
    info->hint_string = hint;
    info->usage = USAGE_DEFAULT;
}

static void register_one(const method* m, opaque* class_name, opaque* none, opaque* hint) {
    GDExtensionPropertyInfo result;
    GDExtensionPropertyInfo arguments[MOST_ARGUMENTS];
    GDExtensionClassMethodArgumentMetadata plain[MOST_ARGUMENTS] = {
        GDEXTENSION_METHOD_ARGUMENT_METADATA_NONE};
    opaque names[MOST_ARGUMENTS];
    opaque name = name_of(m->name);
    GDExtensionClassMethodInfo info;
    int i;
    memset(&info, 0, sizeof info);
    describe(&result, m->result, none, none, hint);
    for (i = 0; i < m->count; ++i) {
        names[i] = name_of(m->argument[i]);
        describe(&arguments[i], m->type[i], &names[i], none, hint);
    }
    info.name = &name;
    info.method_userdata = (void*)m;
    info.call_func = call_any;
    info.ptrcall_func = call_typed;
    info.method_flags = GDEXTENSION_METHOD_FLAGS_DEFAULT;
    info.has_return_value = m->result != VOID;
    info.return_value_info = &result;
    info.return_value_metadata = GDEXTENSION_METHOD_ARGUMENT_METADATA_NONE;
    info.argument_count = (uint32_t)m->count;
    info.arguments_info = arguments;
    info.arguments_metadata = plain;
    godot.register_method(library, class_name, &info);
    for (i = 0; i < m->count; ++i) {
        forget(&names[i]);
    }
    forget(&name);
}

static GDExtensionPtrBuiltInMethod method_of_bytes(const char* text, GDExtensionInt hash) {
    opaque name = name_of(text);
    const GDExtensionPtrBuiltInMethod found = godot.builtin_method(BYTES, &name, hash);
    forget(&name);
    return found;
}

static void initialize(void* data, GDExtensionInitializationLevel level) {
    GDExtensionClassCreationInfo2 info;
    opaque class_name;
    opaque parent;
    opaque none;
    opaque hint = {{0}};
    size_t i;
    (void)data;
    if (level != GDEXTENSION_INITIALIZATION_SCENE) {
        return;
    }
    bytes_size = method_of_bytes("size", HASH_SIZE);
    bytes_resize = method_of_bytes("resize", HASH_RESIZE);
    if (bytes_size == NULL || bytes_resize == NULL) {
        godot.print_error(
            "this version of Godot has other packed arrays", "initialize", __FILE__, __LINE__, 1);
        return;
    }
    class_name = name_of(CLASS_NAME);
    parent = name_of("RefCounted");
    none = name_of("");
    godot.string_new(&hint, "", 0);
    memset(&info, 0, sizeof info);
    info.is_exposed = 1;
    info.create_instance_func = create;
    info.free_instance_func = destroy;
    godot.register_class(library, &class_name, &parent, &info);
    for (i = 0; i < kMethodCount; ++i) {
        register_one(&kMethods[i], &class_name, &none, &hint);
    }
    forget(&class_name);
    forget(&parent);
    forget(&none);
    godot.destructor(STRING)(&hint);
}

static void deinitialize(void* data, GDExtensionInitializationLevel level) {
    (void)data;
    if (level == GDEXTENSION_INITIALIZATION_SCENE && bytes_size != NULL && bytes_resize != NULL) {
        opaque name = name_of(CLASS_NAME);
        godot.unregister_class(library, &name);
        forget(&name);
    }
}

/* The entry symbol of the .gdextension file. False: this Godot lacks something, which print_error
 * names. */
__attribute__((visibility("default"))) GDExtensionBool zoned_godot_init(
    GDExtensionInterfaceGetProcAddress get,
    GDExtensionClassLibraryPtr for_library,
    GDExtensionInitialization* out) {
    static const char* const kNames[] = {"print_error",
                                         "variant_get_type",
                                         "get_variant_from_type_constructor",
                                         "get_variant_to_type_constructor",
                                         "variant_get_ptr_constructor",
                                         "variant_get_ptr_destructor",
                                         "variant_get_ptr_builtin_method",
                                         "string_new_with_utf8_chars_and_len",
                                         "string_to_utf8_chars",
                                         "string_name_new_with_latin1_chars",
                                         "packed_byte_array_operator_index",
                                         "packed_byte_array_operator_index_const",
                                         "classdb_construct_object",
                                         "object_set_instance",
                                         "classdb_register_extension_class2",
                                         "classdb_register_extension_class_method",
                                         "classdb_unregister_extension_class"};
    GDExtensionInterfaceFunctionPtr found[sizeof kNames / sizeof kNames[0]];
    size_t i;
    _Static_assert(sizeof found == sizeof godot,
                   "a name for each function, in the order of the struct");
    for (i = 0; i < sizeof kNames / sizeof kNames[0]; ++i) {
        found[i] = get(kNames[i]);
        if (found[i] == NULL) {
            if (i > 0) {
                ((GDExtensionInterfacePrintError)found[0])(
                    kNames[i],
                    "zoned_godot_init: this version of Godot lacks a function",
                    __FILE__,
                    __LINE__,
                    1);
            }
            return 0;
        }
    }
    memcpy(&godot, found, sizeof godot);
    library = for_library;
    out->minimum_initialization_level = GDEXTENSION_INITIALIZATION_SCENE;
    out->initialize = initialize;
    out->deinitialize = deinitialize;
    return 1;
}
