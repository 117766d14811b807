"""A program: a closed algorithm as C99 in one header, with names and units for all that goes in and out.

The header declares, for a program called NAME,

    typedef struct NAME NAME;                                          everything that it remembers
    void NAME_init(NAME *me);                                          start at rest, in the neutral pose
    int NAME_step(NAME *me, const double in[], double out[]);          one period; returns the status

and the macros NAME_PERIOD [s], NAME_INPUTS and NAME_OUTPUTS. One source file defines NAME_IMPLEMENTATION
before it includes the header, and so receives the functions; all others include it as it is. The struct holds
no pointers, so a copy of it is a snapshot, and each instance has one of its own. The status is a place in
`otolith.compiled.STATUSES`: 0 for a decision of the algorithm, others for the fallback that brakes.
"""

import re
from dataclasses import dataclass
from typing import Final

from otolith.core.errors import InputError
from otolith.core.frames import AXES

# Names that mean something else where a program is compiled: by C99 and C++ compilers, in the headers that a
# program or its host includes, as the file of such a header, in the test program, and in CMake.
_TAKEN: Final = frozenset(
    """alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl concept const
    const_cast consteval constexpr constinit continue decltype default delete do double dynamic_cast else
    enum explicit export extern false far float for friend goto if inline int interface linux long
    mutable namespace near new noexcept not not_eq nullptr operator or or_eq private protected public
    register reinterpret_cast requires restrict return short signed sizeof static static_assert
    static_cast std struct switch template this thread_local throw true try typedef typeid typename
    typeof union unix unsigned using virtual void volatile wchar_t while xor xor_eq

    a64l abort abs acos acosh arc4random asin asinh atan atan2 atanh atexit atof atoi atol atoll bcmp
    bcopy bsearch bufsiz bzero calloc cbrt ceil clearenv clearerr copysign cos cosh ctermid div dprintf
    drem eof erf erfc exit exit_failure exit_success exp exp2 explicit_bzero expm1 fabs fclose fdim
    fdopen feof ferror fflush ffs ffsl ffsll fgetc fgetpos fgets file fileno finite floor fma fmax
    fmemopen fmin fmod fopen fpclassify fprintf fputc fputs fread free freopen frexp fscanf fseek fseeko
    fsetpos ftell ftello fwrite gamma getc getchar getdelim getenv getline getloadavg gets getsubopt getw
    huge_val hypot ilogb index infinity initstate isfinite isgreater isgreaterequal isinf isless
    islessequal islessgreater isnan isnormal isunordered j0 j1 jn l64a labs ldexp ldiv lgamma llabs lldiv
    llrint llround log log10 log1p log2 logb lrint lround main malloc mblen mbstowcs mbtowc memccpy
    memchr memcmp memcpy memmove memset mkdtemp mkstemp mkstemps mktemp modf nan nearbyint nextafter
    nexttoward null pclose perror popen pow printf pselect putc putchar putenv puts putw qecvt qsort rand
    rand_max random realloc reallocarray realpath remainder remove remquo rename renameat rewind rindex
    rint round rpmatch scalb scalbln scalbn scanf select setbuf setbuffer setenv setlinebuf setstate
    setvbuf signbit signgam significand sin sinh snprintf sprintf sqrt srand srandom sscanf stderr stdin
    stdout stpcpy stpncpy strcasecmp strcat strchr strcmp strcoll strcpy strcspn strdup strerror strlen
    strncasecmp strncat strncmp strncpy strndup strnlen strpbrk strrchr strsep strsignal strspn strstr
    strtod strtof strtok strtol strtold strtoll strtoq strtoul strtoull strtouq strxfrm system tan tanh
    tempnam tgamma tmpfile tmpnam trunc uint ulong ungetc unsetenv ushort valloc vdprintf vfprintf
    vfscanf vprintf vscanf vsnprintf vsprintf vsscanf wcstombs wctomb y0 y1 yn

    alloca assert complex ctype endian errno features fenv float inttypes iso646 limits locale math
    memory setjmp signal stdalign stdarg stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string
    strings tgmath threads time uchar version wchar wctype windows

    instance model program vectors

    all aux clean con edit_cache help install nul package package_source prn rebuild_cache run_tests test
    zero_check""".split()  # noqa: SIM905
)


@dataclass(frozen=True)
class Port:
    """One number that a program receives, or gives, in every period."""

    name: str  # a C identifier, unique among the inputs or the outputs of a program
    unit: str  # as in "m/s2"; empty for a pure number
    meaning: str  # one line for a reader
    start: float = 0.0  # its value at rest, before the first step


def per_axis(name: str, per: str, meaning: str) -> tuple[Port, ...]:
    """Return ports of the six axes, in m or rad `per` something; `meaning` holds {} for an axis."""
    return tuple(
        Port(f"{name}_{axis}", ("rad" if i > 2 else "m") + per, meaning.format(axis))
        for i, axis in enumerate(AXES)
    )


MOTION: Final = (
    per_axis("pose", "", "{}"),
    per_axis("velocity", "/s", "rate of the {}"),
    per_axis("acceleration", "/s2", "second rate of the {}"),
)  # of a platform, relative to its neutral pose


@dataclass(frozen=True, kw_only=True)
class Program:
    """An algorithm, with or without its platform, as one C header.

    Raises
    ------
    InputError : the name is none for C.
    """

    name: str
    period: float  # [s] between two steps
    inputs: tuple[Port, ...]  # in the order of `in`
    outputs: tuple[Port, ...]  # in the order of `out`
    header: str  # the whole text of NAME.h

    def __post_init__(self) -> None:
        check_name(self.name)


def check_name(name: str) -> None:
    """Refuse a name that C does not take, or that means something else already; raises `InputError`."""
    field = "name of the program"
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) or len(name) > 40:
        raise InputError(field, repr(name), "letters, digits and _ after a letter, at most 40")
    plain = name.lower()  # so are the names of files on some systems
    kinds = (plain, plain.removesuffix("f"), plain.removesuffix("l"))  # sinf and sinl are sine, too
    if not _TAKEN.isdisjoint(kinds) or plain.endswith("_t") or name.startswith("M_"):
        bound = "one that has no meaning yet in C, C++, their libraries or CMake"
        raise InputError(field, repr(name), bound)


def check_free(name: str, *codes: str) -> None:
    """Refuse a name that is a word of the C code around a program; raises `InputError`."""
    for code in codes:
        words = re.sub(r"/\*.*?\*/|//[^\n]*|\"[^\"\n]*\"|@\w+@", " ", code, flags=re.DOTALL)
        if re.search(rf"\b{name}\b", words):
            raise InputError("name of the program", repr(name), "no word of the code that goes around it")
