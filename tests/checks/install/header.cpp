// daft.h is C++ too: it compiles there with every warning on, and its functions have C names.
#include <daft.h>

int main()
{
    daft_vec3 up = {0, 1, 0};
    daft_engine_def (*maker)(void) = &daft_default_engine_def;
    return maker != nullptr && up.y > 0 && DAFT_VERSION_MAJOR >= 0 ? 0 : 1;
}
