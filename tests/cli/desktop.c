/* SPDX-License-Identifier: MIT */
/*
 * What a desktop does to a window and xdotool cannot:
 *   desktop WINDOW close      asks it to close, as the cross of a title bar
 *   desktop WINDOW drop URI   drags a file from another window and drops it
 *   desktop root dpi N        says how fine the display is, as settings do
 * Dropping is the protocol XDND, version 5, of which this is the source.
 */
#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    WAIT_S = 60
};

static Display *display;

static Atom atom(const char *name)
{
    return XInternAtom(display, name, False);
}

static void tell(Window to, const char *kind, const long data[5])
{
    XEvent e = {.xclient = {.type = ClientMessage,
                            .window = to,
                            .message_type = atom(kind),
                            .format = 32}};

    memcpy(e.xclient.data.l, data, 5 * sizeof data[0]);
    XSendEvent(display, to, False, NoEventMask, &e);
    XFlush(display);
}

static void close_window(Window to)
{
    const long data[5] = {(long)atom("WM_DELETE_WINDOW"), CurrentTime};
    tell(to, "WM_PROTOCOLS", data);
    XSync(display, False);
}

/* The target asks for what is dragged. */
static void answer(const XSelectionRequestEvent *asked, const char *uri)
{
    XEvent e = {.xselection = {.type = SelectionNotify,
                               .requestor = asked->requestor,
                               .selection = asked->selection,
                               .target = asked->target,
                               .property = asked->property,
                               .time = asked->time}};

    XChangeProperty(display, asked->requestor, asked->property, asked->target,
                    8, PropModeReplace, (const unsigned char *)uri,
                    (int)strlen(uri));
    XSendEvent(display, asked->requestor, False, NoEventMask, &e);
    XFlush(display);
}

static Window make_source(void)
{
    return XCreateSimpleWindow(display, DefaultRootWindow(display), 0, 0, 1, 1,
                               0, 0, 0);
}

static void drag(Window from, Window to)
{
    const long source = (long)from, list = (long)atom("text/uri-list");
    const long enter[5] = {source, 5 << 24, list};
    const long position[5] = {source, 0, 5 << 16 | 5, CurrentTime,
                              (long)atom("XdndActionCopy")};

    tell(to, "XdndEnter", enter);
    tell(to, "XdndPosition", position);
}

static void drop(Window to, const char *uri)
{
    const Window from = make_source();
    const long now[5] = {(long)from, 0, CurrentTime};

    XSetSelectionOwner(display, atom("XdndSelection"), from, CurrentTime);
    drag(from, to);
    for (;;) {
        XEvent e;
        XNextEvent(display, &e);
        if (e.type == SelectionRequest)
            answer(&e.xselectionrequest, uri);
        if (e.type != ClientMessage)
            continue;
        if (e.xclient.message_type == atom("XdndStatus"))
            tell(to, "XdndDrop", now);
        if (e.xclient.message_type == atom("XdndFinished"))
            return;
    }
}

static void set_dpi(const char *dpi)
{
    char text[64];
    const int size = snprintf(text, sizeof text, "Xft.dpi:\t%s\n", dpi);

    XChangeProperty(display, DefaultRootWindow(display), XA_RESOURCE_MANAGER,
                    XA_STRING, 8, PropModeReplace, (unsigned char *)text, size);
    XSync(display, False);
}

int main(int argc, char **argv)
{
    display = XOpenDisplay(NULL);
    if (!display || argc < 3) {
        fprintf(stderr, "desktop WINDOW close|drop|dpi [URI|N], on a "
                        "display\n");
        return 2;
    }
    const Window to = strtoul(argv[1], NULL, 0);
    alarm(WAIT_S); /* for a target that does not answer */
    if (!strcmp(argv[2], "close"))
        close_window(to);
    else if (!strcmp(argv[2], "drop") && argc == 4)
        drop(to, argv[3]);
    else if (!strcmp(argv[2], "dpi") && argc == 4)
        set_dpi(argv[3]);
    else
        return 2;
    XCloseDisplay(display);
    return 0;
}
