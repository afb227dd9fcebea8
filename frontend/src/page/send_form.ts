/** Sends the form of a page as soon as it is shown: whoever came here has pressed enough. */

document.querySelector<HTMLFormElement>("main form")?.requestSubmit();
