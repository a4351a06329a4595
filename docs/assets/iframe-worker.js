// Browsers refuse workers to a page that was opened from a folder. There, the search runs in a
// hidden frame instead: what is posted to it, and what it posts, become events of the two windows.
if (location.protocol === "file:") {
  class IFrameWorker extends EventTarget {
    constructor(url) {
      super()
      const frame = document.createElement("iframe")
      frame.hidden = true
      document.body.append(frame)
      const inside = frame.contentWindow
      inside.postMessage = (data) => {
        const event = new MessageEvent("message", { data })
        this.dispatchEvent(event)
        if (this.onmessage) this.onmessage(event)
      }
      inside.importScripts = (...urls) =>
        urls.reduce((before, each) => before.then(() => load(inside, each)), Promise.resolve())
      this.inside = inside
      this.ready = load(inside, url)
    }

    postMessage(data) {
      const { MessageEvent: Inner } = this.inside
      this.ready.then(() => this.inside.dispatchEvent(new Inner("message", { data })))
    }

    terminate() {
      this.inside.frameElement.remove()
    }
  }

  const load = (inside, url) =>
    new Promise((done, failed) => {
      const script = inside.document.createElement("script")
      script.src = new URL(url, location.href).href
      script.onload = done
      script.onerror = failed
      inside.document.body.append(script)
    })

  window.IFrameWorker = window.Worker = IFrameWorker
}
