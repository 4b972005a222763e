/* Godot's side of the interface: variants, texts and packed arrays, and the one class that an
 * extension registers. */
#include "godot_side.h"

#include <string.h>

int live;
const char* without = "";
method methods[64];
size_t method_count;
GDExtensionClassCreationInfo2 class_info;
int classes;
const GDExtensionClassLibraryPtr kLibrary = &classes;

block* new_block(const void* data, int64_t size) {
    block* const out = calloc(1, sizeof *out + (size_t)size + 1);
    CHECK(out != NULL);
    out->size = size;
    if (data != NULL && size > 0) {
        memcpy(out->data, data, (size_t)size);
    }
    ++live;
    return out;
}

void drop(block** at) {
    if (*at != NULL) {
        free(*at);
        *at = NULL;
        --live;
    }
}

const char* text_of(const void* string) {
    const block* const b = *(block* const*)string;
    return b != NULL ? (const char*)b->data : "";
}

static void print_error(const char* description,
                        const char* function,
                        const char* file,
                        int32_t line,
                        GDExtensionBool notify) {
    (void)file;
    (void)line;
    (void)notify;
    fprintf(stderr, "godot: %s: %s\n", function, description);
}

static GDExtensionVariantType variant_get_type(GDExtensionConstVariantPtr v) {
    return (GDExtensionVariantType)((const variant*)v)->type;
}

void to_variant(int type, variant* to, const void* from) {
    memset(to, 0, sizeof *to);
    to->type = type;
    to->canary = 77;
    switch (type) {
        case STRING: {
            const block* const b = *(block* const*)from;
            to->of.text = b != NULL ? new_block(b->data, b->size) : NULL;
            break;
        }
        case BYTES: {
            const block* const b = ((block* const*)from)[1];
            to->of.bytes[1] = b != NULL ? new_block(b->data, b->size) : NULL;
            break;
        }
        case INT:
            memcpy(&to->of.integer, from, 8);
            break;
        case FLOAT:
            memcpy(&to->of.number, from, 8);
            break;
        case BOOL:
            memcpy(&to->of.truth, from, 1);
            break;
        case VECTOR3:
            memcpy(to->of.part, from, 12);
            break;
        case QUATERNION:
            memcpy(to->of.part, from, 16);
            break;
        default:
            CHECK(!"a type that the host knows");
    }
}

static void from_variant(int type, void* to, const variant* from) {
    variant copy;
    CHECK(from->type == type); /* Godot reads the memory as that type, whatever it is */
    to_variant(type, &copy, &from->of);
    memcpy(to,
           &copy.of,
           type == BOOL                          ? 1
           : type == BYTES || type == QUATERNION ? 16
           : type == VECTOR3                     ? 12
                                                 : 8);
}

#define FOR_EACH_TYPE(X) X(STRING) X(BYTES) X(INT) X(FLOAT) X(BOOL) X(VECTOR3) X(QUATERNION)
#define CONSTRUCTORS(T)                                                       \
    static void make_##T(GDExtensionVariantPtr to, GDExtensionTypePtr from) { \
        to_variant(T, to, from);                                              \
    }                                                                         \
    static void read_##T(GDExtensionTypePtr to, GDExtensionVariantPtr from) { \
        from_variant(T, to, from);                                            \
    }
FOR_EACH_TYPE(CONSTRUCTORS)

static GDExtensionVariantFromTypeConstructorFunc get_variant_from_type_constructor(
    GDExtensionVariantType type) {
#define MAKE(T)          \
    if (type == (T)) {   \
        return make_##T; \
    }
    FOR_EACH_TYPE(MAKE)
    return NULL;
}

static GDExtensionTypeFromVariantConstructorFunc get_variant_to_type_constructor(
    GDExtensionVariantType type) {
#define READ(T)          \
    if (type == (T)) {   \
        return read_##T; \
    }
    FOR_EACH_TYPE(READ)
    return NULL;
}

static void construct_bytes(GDExtensionTypePtr to, const GDExtensionConstTypePtr* arguments) {
    (void)arguments;
    ((block**)to)[0] = NULL;
    ((block**)to)[1] = new_block(NULL, 0);
}

static GDExtensionPtrConstructor variant_get_ptr_constructor(GDExtensionVariantType type,
                                                             int32_t number) {
    return type == BYTES && number == 0 ? construct_bytes : NULL;
}

static void destroy_text(GDExtensionTypePtr text) {
    drop(text);
}

static void destroy_bytes(GDExtensionTypePtr bytes) {
    drop(&((block**)bytes)[1]);
}

static GDExtensionPtrDestructor variant_get_ptr_destructor(GDExtensionVariantType type) {
    return type == BYTES ? destroy_bytes : type == STRING || type == NAME ? destroy_text : NULL;
}

static void size_of_bytes(GDExtensionTypePtr base,
                          const GDExtensionConstTypePtr* arguments,
                          GDExtensionTypePtr result,
                          int count) {
    const block* const b = ((block**)base)[1];
    const int64_t size = b != NULL ? b->size : 0;
    (void)arguments;
    CHECK(count == 0);
    memcpy(result, &size, sizeof size);
}

static void resize_bytes(GDExtensionTypePtr base,
                         const GDExtensionConstTypePtr* arguments,
                         GDExtensionTypePtr result,
                         int count) {
    const int64_t size = *(const int64_t*)arguments[0];
    const int64_t good = 0;
    CHECK(count == 1 && size >= 0);
    drop(&((block**)base)[1]);
    ((block**)base)[1] = new_block(NULL, size);
    memcpy(result, &good, sizeof good);
}

static GDExtensionPtrBuiltInMethod variant_get_ptr_builtin_method(
    GDExtensionVariantType type,
    GDExtensionConstStringNamePtr name,
    GDExtensionInt hash) {
    CHECK(type == BYTES);
    return strcmp(text_of(name), "size") == 0 && hash == 3173160232    ? size_of_bytes
           : strcmp(text_of(name), "resize") == 0 && hash == 848867239 ? resize_bytes
                                                                       : NULL;
}

static void string_new_with_utf8_chars_and_len(GDExtensionStringPtr to,
                                               const char* text,
                                               GDExtensionInt size) {
    *(block**)to = size > 0 ? new_block(text, size) : NULL;
}

static GDExtensionInt string_to_utf8_chars(GDExtensionConstStringPtr string,
                                           char* to,
                                           GDExtensionInt most) {
    const block* const b = *(block* const*)string;
    const int64_t size = b != NULL ? b->size : 0;
    if (to != NULL) {
        memcpy(to, text_of(string), (size_t)(size < most ? size : most));
    }
    return size;
}

static void string_name_new_with_latin1_chars(GDExtensionStringNamePtr to,
                                              const char* text,
                                              GDExtensionBool is_static) {
    CHECK(!is_static);
    *(block**)to = new_block(text, (int64_t)strlen(text));
}

static uint8_t* packed_byte_array_operator_index(GDExtensionTypePtr bytes, GDExtensionInt index) {
    block* const b = ((block**)bytes)[1];
    CHECK(b != NULL && index < b->size);
    return b->data + index;
}

static const uint8_t* packed_byte_array_operator_index_const(GDExtensionConstTypePtr bytes,
                                                             GDExtensionInt index) {
    return packed_byte_array_operator_index((void*)bytes, index);
}

static GDExtensionObjectPtr classdb_construct_object(GDExtensionConstStringNamePtr name) {
    CHECK(strcmp(text_of(name), "RefCounted") == 0);
    return calloc(1, sizeof(object));
}

static void object_set_instance(GDExtensionObjectPtr o,
                                GDExtensionConstStringNamePtr name,
                                GDExtensionClassInstancePtr instance) {
    CHECK(strcmp(text_of(name), "ZonedClient") == 0 && instance != NULL);
    ((object*)o)->instance = instance;
}

static void classdb_register_extension_class2(GDExtensionClassLibraryPtr library,
                                              GDExtensionConstStringNamePtr name,
                                              GDExtensionConstStringNamePtr parent,
                                              const GDExtensionClassCreationInfo2* info) {
    CHECK(library == kLibrary);
    CHECK(strcmp(text_of(name), "ZonedClient") == 0 && strcmp(text_of(parent), "RefCounted") == 0);
    CHECK(info->is_exposed && !info->is_virtual && !info->is_abstract &&
          info->create_instance_func && info->free_instance_func);
    class_info = *info;
    ++classes;
}

static void check_property(const GDExtensionPropertyInfo* info) {
    CHECK(info->name != NULL && info->class_name != NULL && info->hint_string != NULL &&
          info->usage == 6);
}

static void classdb_register_extension_class_method(GDExtensionClassLibraryPtr library,
                                                    GDExtensionConstStringNamePtr name,
                                                    const GDExtensionClassMethodInfo* info) {
    method* const m = &methods[method_count++];
    uint32_t i;
    CHECK(library == kLibrary && classes == 1 && strcmp(text_of(name), "ZonedClient") == 0);
    CHECK(info->call_func && info->ptrcall_func &&
          info->method_flags == GDEXTENSION_METHOD_FLAGS_DEFAULT && info->argument_count <= 8);
    CHECK(info->default_argument_count == 0);
    snprintf(m->name, sizeof m->name, "%s", text_of(info->name));
    m->call = info->call_func;
    m->typed = info->ptrcall_func;
    m->data = info->method_userdata;
    m->count = info->argument_count;
    for (i = 0; i < m->count; ++i) {
        check_property(&info->arguments_info[i]);
        CHECK(text_of(info->arguments_info[i].name)[0] != 0);
        m->type[i] = (int)info->arguments_info[i].type;
    }
    if (info->has_return_value) {
        check_property(info->return_value_info);
        m->result = (int)info->return_value_info->type;
    }
}

static void classdb_unregister_extension_class(GDExtensionClassLibraryPtr library,
                                               GDExtensionConstStringNamePtr name) {
    CHECK(library == kLibrary && strcmp(text_of(name), "ZonedClient") == 0);
    --classes;
}

GDExtensionInterfaceFunctionPtr get_proc_address(const char* name) {
#define OFFER(F)                                               \
    if (strcmp(name, #F) == 0 && strcmp(name, without) != 0) { \
        return (GDExtensionInterfaceFunctionPtr)(void*)F;      \
    }
    OFFER(print_error)
    OFFER(variant_get_type)
    OFFER(get_variant_from_type_constructor)
    OFFER(get_variant_to_type_constructor)
    OFFER(variant_get_ptr_constructor)
    OFFER(variant_get_ptr_destructor)
    OFFER(variant_get_ptr_builtin_method)
    OFFER(string_new_with_utf8_chars_and_len)
    OFFER(string_to_utf8_chars)
    OFFER(string_name_new_with_latin1_chars)
    OFFER(packed_byte_array_operator_index)
    OFFER(packed_byte_array_operator_index_const)
    OFFER(classdb_construct_object)
    OFFER(object_set_instance)
    OFFER(classdb_register_extension_class2)
    OFFER(classdb_register_extension_class_method)
    OFFER(classdb_unregister_extension_class)
    return NULL;
}
